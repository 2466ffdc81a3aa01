// SPDX-License-Identifier: MIT
// Each rank publishes, for each level, the box around its homes of that level and all finer
// ones. An object of level l goes to a lower rank where it meets the box of level l, and to a
// higher one where it meets that of level l - 1: where it would not be the owner (owner.h).
#include "cluster/ghosts.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <stdlib.h>

// A home that is a ghost elsewhere.
typedef struct visit {
    uint32_t home;
    int rank;
    uint64_t to; // row of what is sent
} visit;

typedef struct visits {
    visit *list;
    uint64_t n;
    uint64_t capacity;
} visits;

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
    visits parts[PARALLEL_MOST];
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
                s->failed[part] |= !add_visit(&s->parts[part], i, rank);
        }
    }
}

static bool find_visits(visits *v, const level_boxes *all, const ranks *r, const homes *h,
                        duet_error *err)
{
    search *s = calloc(1, sizeof *s);
    int *neighbours = malloc((size_t)r->n * sizeof *neighbours);
    bool ok = s && neighbours;
    if (ok) {
        *s = (search){.h = h, .all = all, .self = r->self, .neighbours = neighbours};
        s->n_neighbours = find_neighbours(all, r, neighbours);
        if (s->n_neighbours > 0)
            parallel_each(h->threads, h->border.n, search_part, s);
    }
    for (int part = 0; s && part < PARALLEL_MOST; ++part) {
        ok = ok && !s->failed[part];
        for (uint64_t k = 0; ok && k < s->parts[part].n; ++k)
            ok = add_visit(v, s->parts[part].list[k].home, s->parts[part].list[k].rank);
        free(s->parts[part].list);
    }
    free(neighbours);
    free(s);
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

bool ghosts_exchange(const homes *h, ranks *r, bool ok, parcels *in, duet_error *err)
{
    visits v = {0};
    parcels out = {0};
    ranks_gather(r, &h->boxes, h->all, sizeof h->boxes);
    ok = ok && find_visits(&v, h->all, r, h, err);
    ok = parcels_begin(&out, r, object_message_bytes(&h->form), err) && ok;
    ok = ok && write_visits(&v, r, h, &out, err);
    ok = ranks_exchange(r, ok, &out, in, err);
    parcels_end(&out);
    free(v.list);
    return ok;
}
