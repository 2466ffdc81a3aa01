// SPDX-License-Identifier: MIT
// Each domain publishes, for each level, the box around its objects of that level and all finer
// ones. An object of level l goes to a lower place if it meets the box of level l, and to a higher
// one if it meets the box of level l - 1: to places that may own the pair (owner.h).
#include "cluster/ghosts.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

typedef struct search {
    const owned *o;
    ghosts *g;
    uint32_t first_place; // this rank's first place
    row_list neighbours;  // places: of each domain those whose boxes meet its own
    uint64_t *first;      // [n_domains + 1] of each domain's neighbours
    uint64_t *counts;     // [PARALLEL_MOST][n_ranks] of each part's visits, and then where they go
    int n_ranks;
} search;

static const extent *all_of(const ghosts *g, uint32_t place)
{
    return &g->boxes[place].upto[SIZE_LEVELS - 1];
}

static bool list_neighbours(search *s)
{
    uint32_t n = s->o->n_domains, n_places = s->o->most_domains * (uint32_t)s->n_ranks;
    s->first = malloc((n + 1) * sizeof *s->first);
    for (uint32_t d = 0; s->first && d < n; ++d) {
        s->first[d] = s->neighbours.n;
        for (uint32_t q = 0; q < n_places; ++q)
            if (q != s->first_place + d &&
                extents_meet(all_of(s->g, q), all_of(s->g, s->first_place + d)))
                row_list_add(&s->neighbours, q);
        s->first[d + 1] = s->neighbours.n;
    }
    return s->first && !s->neighbours.failed;
}

// No extent is longer than `widest`; most objects are farther than that from all neighbours.
static bool is_near(const search *s, uint32_t d, const double centre[3])
{
    double far = s->o->widest;
    const extent around = {{centre[0] - far, centre[1] - far, centre[2] - far},
                           {centre[0] + far, centre[1] + far, centre[2] + far}};
    for (uint64_t k = s->first[d]; k < s->first[d + 1]; ++k)
        if (extents_meet(all_of(s->g, s->neighbours.rows[k]), &around))
            return true;
    return false;
}

enum { ROWS_AHEAD = 8 }; // that are asked for; they lie anywhere

static void search_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    search *s = context;
    const owned *o = s->o;
    visit_list found = s->g->parts[part]; // apart from what other threads write
    uint64_t *counts = s->counts + part * (size_t)s->n_ranks;
    for (uint64_t at = first; at < end; ++at) {
        uint32_t row = o->boundary.rows[at];
        const void *object = object_row(&o->rows, &o->form, row);
        double centre[3];
        if (at + ROWS_AHEAD < end)
            __builtin_prefetch(object_row(&o->rows, &o->form, o->boundary.rows[at + ROWS_AHEAD]));
        object_centre(&o->form, object, centre);
        uint32_t d = owned_domain_at(o, centre), from = s->first_place + d;
        if (!is_near(s, d, centre))
            continue;
        extent e = extent_of(&o->form, object);
        int own_level = level_of(extent_widest(&e), o->widest);
        for (uint64_t k = s->first[d]; k < s->first[d + 1]; ++k) {
            uint32_t to = s->neighbours.rows[k];
            int level = owners_upto(own_level, from, to);
            if (level < 0 || !extents_meet(&s->g->boxes[to].upto[level], &e))
                continue;
            list_add(&found.list, &(visit){row, from, to}, 1, sizeof(visit));
            ++counts[to / o->most_domains];
        }
    }
    s->g->parts[part] = found;
}

static bool find_visits(search *s, duet_error *err)
{
    s->counts = calloc(PARALLEL_MOST * (size_t)s->n_ranks, sizeof *s->counts);
    bool ok = s->counts && list_neighbours(s);
    for (int part = 0; part < PARALLEL_MOST; ++part)
        list_clear(&s->g->parts[part].list);
    if (ok && s->first[s->o->n_domains] > 0)
        parallel_each(s->o->threads, s->o->boundary.n, search_part, s);
    for (int part = 0; ok && part < PARALLEL_MOST; ++part)
        ok = !s->g->parts[part].failed;
    return ok || no_memory(err, "ghosts");
}

static uint32_t message_bytes(const object_form *form)
{
    return object_message_bytes(form) + 2 * (uint32_t)sizeof(uint32_t);
}

// Writes the visits that the same part of the search has found.
static void write_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const search *s = context;
    const owned *o = s->o;
    const visit_list *found = &s->g->parts[part];
    uint64_t *places = s->counts + part * (size_t)s->n_ranks;
    (void)first, (void)end;
    for (uint64_t i = 0; i < found->n; ++i) {
        visit v = found->visits[i];
        if (i + ROWS_AHEAD < found->n) {
            uint32_t next = found->visits[i + ROWS_AHEAD].row;
            __builtin_prefetch(object_row(&o->rows, &o->form, next));
            __builtin_prefetch(&o->rows.ids[next]);
        }
        unsigned char *to = (unsigned char *)s->g->out.rows +
                            places[v.to / o->most_domains]++ * s->g->out.row_bytes;
        object_write_message(&o->form, to, o->rows.ids[v.row],
                             object_row(&o->rows, &o->form, v.row));
        memcpy(to + object_message_bytes(&o->form), &v.from, 2 * sizeof v.from);
    }
}

_Static_assert(offsetof(visit, to) == offsetof(visit, from) + sizeof(uint32_t), "side by side");

// Makes counts where each part's visits of a rank go: behind those of the parts before it.
static bool write_visits(search *s, const ranks *r, duet_error *err)
{
    parcels *out = &s->g->out;
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    bool ok = places || no_memory(err, "%d ranks", r->n);
    for (int part = 0; ok && part < PARALLEL_MOST; ++part)
        for (int q = 0; q < r->n; ++q)
            out->counts[q] += s->counts[part * (size_t)r->n + (size_t)q];
    ok = ok && parcels_reserve(out, r, places, err);
    for (int q = 0; ok && q < r->n; ++q)
        for (int part = 0; part < PARALLEL_MOST; ++part) {
            uint64_t *count = &s->counts[part * (size_t)r->n + (size_t)q], n = *count;
            *count = places[q];
            places[q] += n;
        }
    if (ok && out->n > 0)
        parallel_each(s->o->threads, s->o->boundary.n, write_part, s);
    free(places);
    return ok;
}

// ---------------------------------------------------------------- those that came

static const unsigned char *message_at(const ghosts *g, uint64_t i)
{
    return (const unsigned char *)g->in.rows + i * g->in.row_bytes;
}

static uint32_t place_in(const ghosts *g, uint64_t i, uint32_t which)
{
    uint32_t place;
    memcpy(&place, message_at(g, i) + g->in.row_bytes - (2 - which) * sizeof place, sizeof place);
    return place;
}

ghost ghosts_get(const ghosts *g, uint64_t i)
{
    uint64_t at = g->list ? g->list[i] : i;
    const unsigned char *message = message_at(g, at);
    ghost found = {.object = message + sizeof found.id, .from = place_in(g, at, 0)};
    memcpy(&found.id, message, sizeof found.id);
    return found;
}

static void list_by_domain(ghosts *g, uint32_t n_domains, uint32_t first_place)
{
    uint64_t before = 0;
    for (uint64_t i = 0; i < g->in.n; ++i)
        ++g->first[place_in(g, i, 1) - first_place + 1];
    for (uint32_t d = 1; d <= n_domains; ++d) {
        uint64_t own = g->first[d];
        g->first[d] = before;
        before += own;
    }
    for (uint64_t i = 0; i < g->in.n; ++i)
        g->list[g->first[place_in(g, i, 1) - first_place + 1]++] = (uint32_t)i;
}

bool ghosts_sort(ghosts *g, const owned *o, const ranks *r, duet_error *err)
{
    uint32_t n = o->n_domains;
    free(g->list);
    g->list = n > 1 ? malloc((g->in.n + 1) * sizeof *g->list) : NULL;
    if (n > 1 && !g->list)
        return no_memory(err, "ghosts");
    memset(g->first, 0, (n + 1) * sizeof *g->first);
    if (n == 1)
        g->first[1] = g->in.n;
    else
        list_by_domain(g, n, (uint32_t)r->self * o->most_domains);
    return true;
}

bool ghosts_exchange(ghosts *g, const owned *o, ranks *r, duet_error *err)
{
    search s = {.o = o, .g = g, .n_ranks = r->n};
    s.first_place = (uint32_t)r->self * o->most_domains;
    ranks_gather(r, o->boxes, g->boxes, (int)(o->most_domains * sizeof *g->boxes));
    bool ok = is_well(err) && find_visits(&s, err);
    ok = parcels_begin(&g->out, r, message_bytes(&o->form), err) && ok;
    ok = ok && write_visits(&s, r, err);
    free(s.neighbours.rows);
    free(s.first);
    free(s.counts);
    return parcels_exchange(r, ok, &g->out, &g->in, err);
}

bool ghosts_begin(ghosts *g, const owned *o, const ranks *r, duet_error *err)
{
    *g = (ghosts){0};
    g->boxes = malloc((size_t)r->n * o->most_domains * sizeof *g->boxes);
    g->first = malloc((o->n_domains + 1) * sizeof *g->first);
    return (g->boxes && g->first) || no_memory(err, "boxes of %d ranks", r->n);
}

void ghosts_end(ghosts *g)
{
    for (int part = 0; part < PARALLEL_MOST; ++part)
        free(g->parts[part].visits);
    free(g->boxes);
    free(g->first);
    free(g->list);
    parcels_end(&g->in);
    parcels_end(&g->out);
    *g = (ghosts){0};
}
