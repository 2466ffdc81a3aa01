// SPDX-License-Identifier: MIT
// Each rank publishes, for each level, the box around its homes of that level and all finer
// ones. An object of level l goes to a lower rank where it meets the box of level l, and to a
// higher one where it meets that of level l - 1: where it would not be the owner (owner.h).
#include "cluster/ghosts.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <stdlib.h>
#include <string.h>

static bool add_visit(visits *v, uint32_t home, uint32_t neighbour)
{
    if (v->n == v->capacity) {
        uint64_t capacity = v->capacity ? 2 * v->capacity : 1024;
        visit *list = realloc(v->list, capacity * sizeof *list);
        if (!list)
            return false;
        v->list = list;
        v->capacity = capacity;
    }
    v->list[v->n++] = (visit){home, neighbour};
    return true;
}

typedef struct search {
    const homes *h;
    const level_boxes *all; // [n of ranks]
    int self;
    int *neighbours; // [n_neighbours] ranks
    uint32_t n_neighbours;
    visits *parts;    // [PARALLEL_MOST]
    uint64_t *counts; // [PARALLEL_MOST][stride], of each part's visits, and then where they go
    size_t stride;
    bool failed[PARALLEL_MOST];
    parcels *out;
} search;

// Numbers of two parts lie so far apart that threads do not wait for each other's.
enum { APART = 64 / sizeof(uint64_t) };

// Which ranks' boxes meet any home at all; few do.
static bool find_neighbours(search *s, const ranks *r, duet_error *err)
{
    s->neighbours = malloc((size_t)r->n * sizeof *s->neighbours);
    for (int q = 0; s->neighbours && q < r->n; ++q)
        if (q != s->self &&
            reaches_meet(&s->all[q].upto[LEVELS - 1], &s->all[s->self].upto[LEVELS - 1]))
            s->neighbours[s->n_neighbours++] = q;
    s->stride = (size_t)s->n_neighbours + APART;
    s->counts = calloc(PARALLEL_MOST * s->stride, sizeof *s->counts);
    return (s->neighbours && s->counts) ||
           error_set(err, DUET_STATUS_NO_MEMORY, "ghosts: no memory");
}

// No reach is longer than `widest`; most homes are farther than that from all neighbours.
static bool is_near(const search *s, const double centre[3])
{
    double far = s->h->widest;
    const reach around = {{centre[0] - far, centre[1] - far, centre[2] - far},
                          {centre[0] + far, centre[1] + far, centre[2] + far}};
    for (uint32_t k = 0; k < s->n_neighbours; ++k)
        if (reaches_meet(&s->all[s->neighbours[k]].upto[LEVELS - 1], &around))
            return true;
    return false;
}

enum { ROWS_AHEAD = 8 }; // that are asked for; they lie anywhere

static void search_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    search *s = context;
    const homes *h = s->h;
    visits found = s->parts[part]; // apart from what other threads write
    uint64_t *counts = s->counts + part * s->stride;
    bool failed = false;
    for (uint64_t at = first; at < end; ++at) {
        uint32_t i = h->border.rows[at];
        const void *object = object_row(&h->rows, &h->form, i);
        double centre[3];
        if (at + ROWS_AHEAD < end)
            __builtin_prefetch(object_row(&h->rows, &h->form, h->border.rows[at + ROWS_AHEAD]));
        object_centre(&h->form, object, centre);
        if (!is_near(s, centre))
            continue;
        reach e = reach_of(&h->form, object);
        int own_level = level_of(reach_widest(&e), h->widest);
        for (uint32_t k = 0; k < s->n_neighbours; ++k) {
            int rank = s->neighbours[k],
                level = owners_upto(own_level, (uint32_t)s->self, (uint32_t)rank);
            if (level < 0 || homes_came_from(h, i, rank) ||
                !reaches_meet(&s->all[rank].upto[level], &e))
                continue;
            failed |= !add_visit(&found, i, k);
            ++counts[k];
        }
    }
    s->parts[part] = found;
    s->failed[part] = failed;
}

static bool find_visits(search *s, const ranks *r, duet_error *err)
{
    bool ok = find_neighbours(s, r, err);
    for (int part = 0; part < PARALLEL_MOST; ++part)
        s->parts[part].n = 0;
    if (ok && s->n_neighbours > 0)
        parallel_each(s->h->threads, s->h->border.n, search_part, s);
    for (int part = 0; ok && part < PARALLEL_MOST; ++part)
        if (s->failed[part])
            ok = error_set(err, DUET_STATUS_NO_MEMORY, "ghosts: no memory");
    return ok;
}

// The visits that the same part of the search has found.
static void write_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const search *s = context;
    const homes *h = s->h;
    const visits *found = &s->parts[part];
    uint64_t *places = s->counts + part * s->stride;
    unsigned char *messages = s->out->rows;
    (void)first, (void)end;
    for (uint64_t i = 0; i < found->n; ++i) {
        visit v = found->list[i];
        if (i + ROWS_AHEAD < found->n) {
            uint32_t next = found->list[i + ROWS_AHEAD].home;
            __builtin_prefetch(object_row(&h->rows, &h->form, next));
            __builtin_prefetch(&h->rows.ids[next]);
        }
        object_write_message(&h->form, messages + places[v.neighbour]++ * s->out->row_bytes,
                             h->rows.ids[v.home], object_row(&h->rows, &h->form, v.home));
    }
}

// Of each neighbour those of a part come behind those of the parts before it.
static void place_visits(search *s, const uint64_t *places)
{
    for (uint32_t k = 0; k < s->n_neighbours; ++k) {
        uint64_t place = places[s->neighbours[k]];
        for (int part = 0; part < PARALLEL_MOST; ++part) {
            uint64_t *count = &s->counts[part * s->stride + k], n = *count;
            *count = place;
            place += n;
        }
    }
}

static bool write_visits(search *s, const ranks *r, duet_error *err)
{
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    bool ok = places || error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    for (uint32_t k = 0; ok && k < s->n_neighbours; ++k)
        for (int part = 0; part < PARALLEL_MOST; ++part)
            s->out->counts[s->neighbours[k]] += s->counts[part * s->stride + k];
    ok = ok && parcels_reserve(s->out, r, places, err);
    if (ok)
        place_visits(s, places);
    if (ok && s->out->n > 0)
        parallel_each(s->h->threads, s->h->border.n, write_part, s);
    free(places);
    return ok;
}

bool ghosts_exchange(ghosts *g, const homes *h, ranks *r, bool ok, duet_error *err)
{
    search s = {.h = h, .all = h->all, .self = r->self, .parts = g->parts, .out = &g->out};
    ranks_gather(r, &h->boxes, h->all, sizeof h->boxes);
    ok = ok && find_visits(&s, r, err);
    ok = parcels_begin(&g->out, r, object_message_bytes(&h->form), err) && ok;
    ok = ok && write_visits(&s, r, err);
    free(s.neighbours);
    free(s.counts);
    return ranks_exchange(r, ok, &g->out, &g->in, err);
}

void ghosts_end(ghosts *g)
{
    for (int part = 0; part < PARALLEL_MOST; ++part)
        free(g->parts[part].list);
    parcels_end(&g->out);
    parcels_end(&g->in);
    *g = (ghosts){0};
}
