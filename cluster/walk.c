// SPDX-License-Identifier: MIT
#include "cluster/walk.h"

#include "base/compare.h"
#include "base/error.h"
#include "cluster/cluster.h"

#include <inttypes.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { PAUSES = 15, SOME_EDGES = 1 << 12 };

// ---------------------------------------------------------------- edges

void walk_free(walk *w)
{
    object_rows_end(&w->edges.rows);
    free(w->edges.ranges);
    free(w->keys);
    free(w->without);
    *w = (walk){0};
}

// Space for n, of which those that there are stay.
static bool reserve(duet_cluster *c, uint64_t n)
{
    walk *w = &c->walk;
    edge_rows *e = &w->edges;
    const object_form *form = &c->homes.form;
    worker *locker = c->workers[1];
    if (n <= e->rows.capacity)
        return true;
    uint64_t kept = atomic_load(&e->n), most = n + n / 4;
    object_rows more = {0};
    uint16_t *ranges = malloc(most * sizeof *ranges);
    if (!ranges || !object_rows_begin(&more, form, most, NULL)) {
        free(ranges);
        return false;
    }
    if (kept > 0) {
        memcpy(more.ids, e->rows.ids, kept * sizeof *more.ids);
        memcpy(more.objects, e->rows.objects, kept * form->bytes);
        memcpy(ranges, e->ranges, kept * sizeof *ranges);
    }
    if (locker->lock)
        locker->lock(locker, NULL, 0);
    object_rows_end(&e->rows);
    free(e->ranges);
    e->rows = more;
    e->ranges = ranges;
    if (locker->lock)
        locker->lock(locker, e->rows.objects, most * form->bytes);
    return true;
}

static void add_row(walk *w, const object_form *form, uint64_t id, const void *object)
{
    uint64_t at = atomic_fetch_add(&w->edges.n, 1);
    w->edges.rows.ids[at] = id;
    w->edges.ranges[at] = NO_RANGE;
    memcpy(w->edges.rows.objects + at * form->bytes, object, form->bytes);
}

static void add_arrivals(duet_cluster *c)
{
    const homes *h = &c->homes;
    for (uint32_t row = h->ranges[h->n_ranges - 1].end; row < h->rows.n; ++row)
        add_row(&c->walk, &h->form, h->rows.ids[row], object_row(&h->rows, &h->form, row));
}

static void add_ghost(duet_cluster *c, uint64_t id, const void *object, uint32_t rank)
{
    walk *w = &c->walk;
    w->keys[w->n_ghosts++] =
        ghost_key(&c->homes, object, rank * c->parts.n, c->parts.n_ranks * c->parts.n);
    add_row(w, &c->homes.form, id, object);
}

// Homes that are gone, and what others sent.
static void add_ghosts(duet_cluster *c)
{
    const homes *h = &c->homes;
    const parcels *in = &c->ghosts.in;
    const unsigned char *message = in->rows;
    for (uint32_t k = 0; k < h->n_gone; ++k)
        add_ghost(c, h->rows.ids[h->gone[k]], object_row(&h->rows, &h->form, h->gone[k]),
                  (uint32_t)h->gone_to[k]);
    for (uint32_t q = 0; q < c->parts.n_ranks; ++q)
        for (uint64_t i = 0; i < in->counts[q]; ++i, message += in->row_bytes) {
            uint64_t id;
            memcpy(&id, message, sizeof id);
            add_ghost(c, id, message + sizeof id, q);
        }
}

static bool add_others(duet_cluster *c, duet_error *err)
{
    walk *w = &c->walk;
    const homes *h = &c->homes;
    uint64_t n_arrived = h->rows.n - h->ranges[h->n_ranges - 1].end;
    uint64_t n_ghosts = h->n_gone + c->ghosts.in.n;
    uint64_t all = atomic_load(&w->edges.n) + n_arrived + n_ghosts;
    free(w->keys);
    w->n_ghosts = 0;
    w->keys = malloc((n_ghosts + 1) * sizeof *w->keys);
    if (all > DUET_MOST_OBJECTS || !w->keys || !reserve(c, all))
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects at edges: no memory",
                         all);
    add_arrivals(c);
    add_ghosts(c);
    return true;
}

// ---------------------------------------------------------------- the walk

// Homes lie in ranges with nothing between or behind them, of a size that is known.
static bool can_walk(const duet_cluster *c)
{
    const homes *h = &c->homes;
    const worker *w = c->workers[0];
    return c->walk.wanted && c->walk.pauses == 0 && !c->is_cold && h->holder && w->skim &&
           w->tell_ids && w->turn_to && w->spares_host && w->spares_host(w) && h->is_cut &&
           h->widest > 0 && h->n_gone == 0 && h->ranges[h->n_ranges - 1].end == h->rows.n;
}

static bool counts(const duet_cluster *c)
{
    return !c->own.lists;
}

static bool send(duet_cluster *c, uint32_t part, duet_error *err)
{
    worker *w = c->workers[part % 2];
    seen *s = &c->seen[part % 2];
    global_ids *ids = &c->walk.ids[part % 2];
    sight_in_place from = parts_sight_in_place(&c->parts, part);
    if (!w->turn_to(w, part, err))
        return false;
    seen_in_place(s, &c->homes, &from);
    *ids = (global_ids){.list = s->rows.ids, .n = s->rows.n, .all_changed = true};
    w->lend(w, s->rows.objects, s->rows.n);
    w->begin(w, s->rows.n, counts(c) ? ids : NULL);
    return true;
}

static uint64_t count_leavers(const walk *w, const look *l)
{
    uint64_t n = 0;
    for (int i = 0; i < PARALLEL_MOST; ++i)
        n += l->parts[i].leavers.n - w->taken[i];
    return n;
}

// Pairs of those that leave are found where they come to, or at edges.
static bool leave_out(walk *w, const look *l, global_ids *ids)
{
    uint64_t n = count_leavers(w, l);
    uint32_t *without = realloc(w->without, (n + 1) * sizeof *without);
    if (!without)
        return false;
    w->without = without;
    for (int i = 0; i < PARALLEL_MOST; ++i) {
        const row_list *rows = &l->parts[i].leavers;
        for (; !rows->failed && w->taken[i] < rows->n; ++w->taken[i])
            *without++ = rows->rows[w->taken[i]] - l->base;
    }
    ids->without = w->without;
    ids->n_without = (uint32_t)(without - w->without);
    qsort(w->without, ids->n_without, sizeof *w->without, compare_uint32);
    return ids->n_without == n;
}

static bool search_alone(duet_cluster *c, const look *l, uint32_t part, duet_error *err)
{
    worker *w = c->workers[part % 2];
    seen *s = &c->seen[part % 2];
    global_ids *ids = &c->walk.ids[part % 2];
    worker_found found = {0};
    if (!leave_out(&c->walk, l, ids) || !seen_leave_out(s, ids->without, ids->n_without, err))
        return false;
    if (seen_homes(s) == 0)
        return true;
    if (counts(c))
        w->tell_ids(w, ids);
    return w->find(w, &found, err) && !found.has_bad && own_pairs_add(&c->own, s, &found, err);
}

// More than these are as much work as all.
static uint64_t most_edges(const duet_cluster *c)
{
    return SOME_EDGES + homes_count(&c->homes) / 4;
}

static bool walk_all(duet_cluster *c, look *l)
{
    duet_error unheard; // what fails is tried again, in the other way
    uint32_t n = c->parts.n;
    bool ok = send(c, 0, &unheard);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = (i + 1 == n || send(c, i + 1, &unheard)) &&
             look_at_range(l, i, c->workers[i % 2], &c->walk.edges) &&
             atomic_load(&c->walk.edges.n) <= most_edges(c) && search_alone(c, l, i, &unheard);
    return ok;
}

bool walk_parts(void *cluster, look *l)
{
    duet_cluster *c = cluster;
    walk *w = &c->walk;
    bool can = can_walk(c);
    w->pauses -= w->wanted && w->pauses > 0;
    w->wanted = false;
    if (!can)
        return false;
    w->pauses = PAUSES; // unless all goes well
    atomic_store(&w->edges.n, 0);
    memset(w->taken, 0, sizeof w->taken);
    uint64_t guess = SOME_EDGES + (w->needed > 0 ? w->needed : 2 * c->homes.edges.n);
    if (!reserve(c, guess))
        return false;
    c->parts.is_cut_anew = false;
    cluster_follow(c);
    parts_forget_ghosts(&c->parts);
    own_pairs_begin(&c->own, !c->def.drops_pairs);
    bool ok = walk_all(c, l);
    w->needed = atomic_load(&w->edges.n);
    for (int i = 0; !ok && i < 2; ++i)
        c->workers[i]->lend(c->workers[i], NULL, 0);
    return ok;
}

// ---------------------------------------------------------------- what is left

// Whether it has come farther into this rank's part than any object is wide.
static bool has_leapt(const duet_cluster *c, uint32_t row)
{
    const homes *h = &c->homes;
    const reach own = cut_box(&c->cut);
    double centre[3];
    object_centre(&h->form, object_row(&h->rows, &h->form, row), centre);
    return reach_holds(&own, centre, h->widest);
}

static bool have_leapt(const duet_cluster *c)
{
    const homes *h = &c->homes;
    bool leapt = h->leapt;
    for (uint32_t row = h->ranges[h->n_ranges - 1].end; !leapt && row < h->rows.n; ++row)
        leapt = has_leapt(c, row);
    return leapt;
}

bool walk_settle(duet_cluster *c, duet_error *err)
{
    walk *w = &c->walk;
    bool even = false;
    w->done = false;
    if (!c->homes.walked)
        return true;
    if (have_leapt(c) || atomic_load(&w->edges.n) > w->edges.rows.capacity)
        return true;
    if (!parts_look_after_walk(&c->parts, &c->homes, &even, err))
        return false;
    if (!even)
        return true;
    if (!add_others(c, err) || !parts_settle_after_walk(&c->parts, &c->homes, err))
        return false;
    parcels_end(&c->ghosts.in);
    w->done = true;
    w->pauses = 0;
    return true;
}

bool walk_end(duet_cluster *c, duet_error *err)
{
    walk *w = &c->walk;
    worker *by = c->workers[0];
    worker_found found = {0};
    sight_at_edges from = {.rows = w->edges.rows,
                           .n_ghosts = w->n_ghosts,
                           .ghost_keys = w->keys,
                           .ranges = w->edges.ranges,
                           .home = c->parts.rank * c->parts.n,
                           .n_homes = c->parts.n_ranks * c->parts.n};
    from.rows.n = (uint32_t)atomic_load(&w->edges.n);
    seen_at_edges(&w->seen, &c->homes, &from);
    if (!by->turn_to(by, c->parts.n, err))
        return false;
    by->lend(by, from.rows.objects, from.rows.n);
    bool ok = seen_homes(&w->seen) == 0 ||
              (by->find(by, &found, err) && seen_check_found(&w->seen, &found, err) &&
               own_pairs_add(&c->own, &w->seen, &found, err));
    by->lend(by, NULL, 0);
    return ok;
}
