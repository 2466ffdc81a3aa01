// SPDX-License-Identifier: MIT
// Each rank publishes, for each level, the box around its homes of that level and all finer
// ones. An object of level l goes to a lower rank where it meets the box of level l, and to a
// higher one where it meets that of level l - 1: where it would not be the owner (owner.h).
#include "cluster/ghosts.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <stdlib.h>
#include <string.h>

static bool add_visit(visits *v, uint32_t home, int rank)
{
    if (v->n == v->capacity) {
        uint64_t capacity = v->capacity ? 2 * v->capacity : 1024;
        visit *list = realloc(v->list, capacity * sizeof *list);
        if (!list)
            return false;
        v->list = list;
        v->capacity = capacity;
    }
    v->list[v->n++] = (visit){.home = home, .rank = rank};
    return true;
}

// Which ranks' boxes meet any home at all; few do.
static int find_neighbours(const level_boxes *all, const ranks *r, int *neighbours)
{
    int n = 0;
    for (int q = 0; q < r->n; ++q)
        if (q != r->self && reaches_meet(&all[q].upto[LEVELS - 1], &all[r->self].upto[LEVELS - 1]))
            neighbours[n++] = q;
    return n;
}

typedef struct search {
    const homes *h;
    const level_boxes *all; // [n of ranks]
    int self;
    int *neighbours;
    int n_neighbours;
    visits *parts; // [PARALLEL_MOST]
    bool failed[PARALLEL_MOST];
} search;

// No reach is longer than `widest`; most homes are farther than that from all neighbours.
static bool is_near(const search *s, const double centre[3])
{
    double far = s->h->widest;
    const reach around = {{centre[0] - far, centre[1] - far, centre[2] - far},
                          {centre[0] + far, centre[1] + far, centre[2] + far}};
    for (int k = 0; k < s->n_neighbours; ++k)
        if (reaches_meet(&s->all[s->neighbours[k]].upto[LEVELS - 1], &around))
            return true;
    return false;
}

static void search_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    search *s = context;
    const homes *h = s->h;
    visits found = s->parts[part]; // apart from what other threads write
    bool failed = false;
    for (uint64_t at = first; at < end; ++at) {
        uint32_t i = h->border.rows[at];
        const void *object = object_row(&h->rows, &h->form, i);
        double centre[3];
        object_centre(&h->form, object, centre);
        if (!is_near(s, centre))
            continue;
        reach e = reach_of(&h->form, object);
        int own_level = level_of(reach_widest(&e), h->widest);
        for (int k = 0; k < s->n_neighbours; ++k) {
            int rank = s->neighbours[k],
                level = owners_upto(own_level, (uint32_t)s->self, (uint32_t)rank);
            if (level >= 0 && !homes_came_from(h, i, rank) &&
                reaches_meet(&s->all[rank].upto[level], &e))
                failed |= !add_visit(&found, i, rank);
        }
    }
    s->parts[part] = found;
    s->failed[part] = failed;
}

// Those that all parts of the search have found.
static bool gather(visits *all, const search *s)
{
    uint64_t n = 0;
    for (int part = 0; part < PARALLEL_MOST; ++part) {
        if (s->failed[part])
            return false;
        n += s->parts[part].n;
    }
    if (n > all->capacity) {
        visit *list = realloc(all->list, n * sizeof *list);
        if (!list)
            return false;
        *all = (visits){.list = list, .capacity = n};
    }
    all->n = 0;
    for (int part = 0; part < PARALLEL_MOST; ++part) {
        const visits *from = &s->parts[part];
        if (from->n > 0)
            memcpy(all->list + all->n, from->list, from->n * sizeof *from->list);
        all->n += from->n;
    }
    return true;
}

static bool find_visits(ghosts *g, const ranks *r, const homes *h, duet_error *err)
{
    search s = {.h = h, .all = h->all, .self = r->self, .parts = g->parts};
    s.neighbours = malloc((size_t)r->n * sizeof *s.neighbours);
    bool ok = s.neighbours;
    for (int part = 0; part < PARALLEL_MOST; ++part)
        g->parts[part].n = 0;
    if (ok)
        s.n_neighbours = find_neighbours(h->all, r, s.neighbours);
    if (s.n_neighbours > 0)
        parallel_each(h->threads, h->border.n, search_part, &s);
    ok = ok && gather(&g->found, &s);
    free(s.neighbours);
    return ok || error_set(err, DUET_STATUS_NO_MEMORY, "ghosts: no memory");
}

typedef struct writing {
    const homes *h;
    const visits *v;
    parcels *out;
} writing;

static void write_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const writing *w = context;
    const homes *h = w->h;
    unsigned char *messages = w->out->rows;
    (void)part;
    for (uint64_t i = first; i < end; ++i) {
        const visit *v = &w->v->list[i];
        object_write_message(&h->form, messages + v->to * w->out->row_bytes, h->rows.ids[v->home],
                             object_row(&h->rows, &h->form, v->home));
    }
}

static bool write_visits(const visits *v, const ranks *r, const homes *h, parcels *out,
                         duet_error *err)
{
    writing w = {h, v, out};
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    bool ok = places || error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    for (uint64_t i = 0; ok && i < v->n; ++i)
        ++out->counts[v->list[i].rank];
    ok = ok && parcels_reserve(out, r, places, err);
    for (uint64_t i = 0; ok && i < v->n; ++i)
        v->list[i].to = places[v->list[i].rank]++;
    if (ok)
        parallel_each(h->threads, v->n, write_part, &w);
    free(places);
    return ok;
}

bool ghosts_exchange(ghosts *g, const homes *h, ranks *r, bool ok, duet_error *err)
{
    ranks_gather(r, &h->boxes, h->all, sizeof h->boxes);
    ok = ok && find_visits(g, r, h, err);
    ok = parcels_begin(&g->out, r, object_message_bytes(&h->form), err) && ok;
    ok = ok && write_visits(&g->found, r, h, &g->out, err);
    return ranks_exchange(r, ok, &g->out, &g->in, err);
}

void ghosts_end(ghosts *g)
{
    for (int part = 0; part < PARALLEL_MOST; ++part)
        free(g->parts[part].list);
    free(g->found.list);
    parcels_end(&g->out);
    parcels_end(&g->in);
    *g = (ghosts){0};
}
