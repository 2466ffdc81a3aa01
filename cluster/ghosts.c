// SPDX-License-Identifier: MIT
// Each rank publishes, for each level, the box around its homes of that level and all finer
// ones. An object of level l goes to a lower rank where it meets the box of level l, and to a
// higher one where it meets that of level l - 1: where it would not be the owner (owner.h).
#include "cluster/ghosts.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <stdlib.h>

typedef struct level_boxes {
    reach upto[LEVELS];
} level_boxes;

static level_boxes find_boxes(const homes *h)
{
    level_boxes boxes;
    for (int l = 0; l < LEVELS; ++l)
        boxes.upto[l] = reach_none;
    for (uint32_t i = 0; i < h->rows.n; ++i)
        reach_add(&boxes.upto[h->levels[i]], &h->reaches[i]);
    for (int l = 1; l < LEVELS; ++l)
        reach_add(&boxes.upto[l], &boxes.upto[l - 1]);
    return boxes;
}

static bool needs(const level_boxes *boxes, int rank, const ranks *r, const homes *h, uint32_t i)
{
    int level = h->levels[i] - (rank > r->self);
    return level >= 0 && reaches_meet(&boxes->upto[level], &h->reaches[i]);
}

// A home that is a ghost elsewhere.
typedef struct visit {
    uint32_t home;
    int rank;
} visit;

typedef struct visits {
    visit *list;
    uint64_t n;
    uint64_t capacity;
} visits;

static bool add_visit(visits *v, uint32_t home, int rank, duet_error *err)
{
    if (v->n == v->capacity) {
        uint64_t capacity = v->capacity ? 2 * v->capacity : 1024;
        visit *list = realloc(v->list, capacity * sizeof *list);
        if (!list)
            return error_set(err, DUET_STATUS_NO_MEMORY, "ghosts: no memory for %llu",
                             (unsigned long long)capacity);
        v->list = list;
        v->capacity = capacity;
    }
    v->list[v->n++] = (visit){home, rank};
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

static bool find_visits(visits *v, const level_boxes *all, const ranks *r, const homes *h,
                        duet_error *err)
{
    int *neighbours = malloc((size_t)r->n * sizeof *neighbours);
    if (!neighbours)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    int n = find_neighbours(all, r, neighbours);
    bool ok = true;
    for (uint32_t i = 0; ok && i < h->rows.n; ++i)
        for (int k = 0; ok && k < n; ++k)
            if (needs(&all[neighbours[k]], neighbours[k], r, h, i))
                ok = add_visit(v, i, neighbours[k], err);
    free(neighbours);
    return ok;
}

static bool write_visits(const visits *v, const ranks *r, const homes *h, parcels *out,
                         duet_error *err)
{
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    bool ok = places || error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    for (uint64_t i = 0; ok && i < v->n; ++i)
        ++out->counts[v->list[i].rank];
    ok = ok && parcels_reserve(out, r, places, err);
    unsigned char *messages = out->rows;
    for (uint64_t i = 0; ok && i < v->n; ++i) {
        uint32_t home = v->list[i].home;
        object_write_message(&h->form, messages + places[v->list[i].rank]++ * out->row_bytes,
                             h->rows.ids[home], object_row(&h->rows, &h->form, home));
    }
    free(places);
    return ok;
}

bool ghosts_exchange(const homes *h, ranks *r, parcels *in, duet_error *err)
{
    level_boxes own = find_boxes(h);
    level_boxes *all = malloc((size_t)r->n * sizeof *all);
    visits v = {0};
    parcels out = {0};
    bool ok = all || error_set(err, DUET_STATUS_NO_MEMORY, "boxes of %d ranks: no memory", r->n);
    ok = ranks_agree(r, ok, err);
    if (ok) {
        ranks_gather(r, &own, all, sizeof own);
        ok = find_visits(&v, all, r, h, err);
        ok = parcels_begin(&out, r, object_message_bytes(&h->form), err) && ok;
        ok = ok && write_visits(&v, r, h, &out, err);
        ok = ranks_exchange(r, ok, &out, in, err);
    }
    parcels_end(&out);
    free(v.list);
    free(all);
    return ok;
}
