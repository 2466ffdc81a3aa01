// SPDX-License-Identifier: MIT
// Parts of homes that lie in a holder's memory, part after part.
#include "cluster/parts.h"

#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { FEW_STRAYS = 1 << 12 };

static uint32_t first_row(const parts *p, uint32_t part)
{
    return part > 0 ? p->ranges[part - 1].end : 0;
}

static bool no_memory(const parts *p, duet_error *err)
{
    return error_set(err, DUET_STATUS_NO_MEMORY,
                     "%" PRIu32 " parts of %" PRIu32 " objects: no memory", p->n, p->homes->rows.n);
}

static void count_homes(parts *p)
{
    for (uint32_t i = 0; i < p->n; ++i)
        p->list[i].n = p->ranges[i].end - first_row(p, i);
}

// ---------------------------------------------------------------- a new cut

typedef struct asking {
    const object_form *form;
    const bisection *cut;
} asking;

static uint32_t part_of(const void *context, const void *object)
{
    const asking *a = context;
    double centre[3];
    object_centre(a->form, object, centre);
    return bisection_part(a->cut, centre);
}

bool parts_cut_in_place(parts *p, homes *h, duet_error *err)
{
    uint32_t *ends = malloc(p->n * sizeof *ends);
    p->homes = h;
    if (!ends || !parts_cut(p, err)) {
        free(ends);
        return no_memory(p, err);
    }
    if (h->n_ranges == 0)
        ghost_block_end(&p->block); // rows of another size, perhaps
    const asking a = {&h->form, &p->cut};
    homes_move_gone_last(h);
    rows_sort(&h->rows, &h->form, homes_count(h), ends, p->n, part_of, &a, h->threads);
    for (uint32_t i = 0; i < p->n; ++i) {
        p->ranges[i].end = ends[i];
        bisection_box(&p->cut, i, p->ranges[i].box.lower, p->ranges[i].box.upper);
    }
    free(ends);
    h->ranges = p->ranges;
    h->n_ranges = p->n;
    count_homes(p);
    p->unevenness = parts_unevenness(p);
    p->is_cut_anew = true;
    return true;
}

// ---------------------------------------------------------------- homes at edges

// The part that a row lies in; behind all of them their number.
static uint32_t range_of(const parts *p, uint32_t row)
{
    uint32_t first = 0, end = p->n;
    while (first < end) {
        uint32_t middle = first + (end - first) / 2;
        if (p->ranges[middle].end <= row)
            first = middle + 1;
        else
            end = middle;
    }
    return first;
}

// Marked are those that are in another part than the one that they lie in.
static void mark_edges(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    parts *p = context;
    const homes *h = p->homes;
    portion *own = parts_portions(p, thread);
    uint64_t n_strays = 0;
    parts_clear_portions(p, thread);
    for (uint64_t i = first; i < end; ++i) {
        uint32_t row = h->edges.rows[i];
        const void *object = object_row(&h->rows, &h->form, row);
        double centre[3];
        object_centre(&h->form, object, centre);
        uint32_t part = bisection_part(&p->cut, centre);
        bool is_stray = part != range_of(p, row);
        reach e = reach_of(&h->form, object);
        level_boxes_add(&own[part].boxes, &e, h->widest);
        p->marks[i] = (uint16_t)(part | (is_stray ? PART_MARKED : 0));
        n_strays += is_stray;
    }
    p->n_border[thread] = n_strays;
}

static void add_stray(parts *p, uint32_t row, uint32_t to)
{
    uint32_t from = range_of(p, row);
    if (from == to)
        return;
    p->strays[p->n_strays++] = (stray){row, to};
    if (from < p->n)
        --p->list[from].n;
    if (to < p->n)
        ++p->list[to].n;
}

static void add_gone(parts *p)
{
    for (uint32_t k = 0; k < p->homes->n_gone; ++k)
        add_stray(p, p->homes->gone[k], p->n);
}

static bool begin_strays(parts *p, uint64_t most, duet_error *err)
{
    free(p->strays);
    p->n_strays = 0;
    p->strays = malloc((most + 1) * sizeof *p->strays);
    count_homes(p);
    return p->strays || no_memory(p, err);
}

// Where very many have strayed a cut is no more work, and needs no memory for them.
static bool are_few(const parts *p)
{
    return p->n_strays <= FEW_STRAYS + homes_count(p->homes) / 8;
}

bool parts_look(parts *p, homes *h, bool *even, duet_error *err)
{
    p->homes = h;
    *even = false;
    if (h->n_ranges == 0)
        return true;
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->ranges[i].end > h->rows.n)
            p->ranges[i].end = h->rows.n;
    if (!parts_reserve_marks(p, h->edges.n))
        return no_memory(p, err);
    uint32_t n_threads = parallel_each(h->threads, h->edges.n, mark_edges, p);
    uint64_t most = h->n_gone;
    parts_join_boxes(p, n_threads);
    for (uint32_t t = 0; t < n_threads; ++t)
        most += p->n_border[t];
    if (!begin_strays(p, most, err))
        return false;
    for (uint64_t i = 0; i < h->edges.n; ++i)
        if (p->marks[i] & PART_MARKED)
            add_stray(p, h->edges.rows[i], part_of_mark(p->marks[i]));
    add_gone(p);
    *even = parts_are_even(p) && are_few(p);
    return true;
}

static void add_if_stray(parts *p, uint32_t row)
{
    double centre[3];
    object_centre(&p->homes->form, object_row(&p->homes->rows, &p->homes->form, row), centre);
    add_stray(p, row, bisection_part(&p->cut, centre));
}

bool parts_look_after_walk(parts *p, homes *h, bool *even, duet_error *err)
{
    p->homes = h;
    uint32_t first_new = p->ranges[p->n - 1].end;
    if (!begin_strays(p, h->outside.n + (h->rows.n - first_new) + h->n_gone, err))
        return false;
    for (uint64_t i = 0; i < h->outside.n; ++i)
        add_if_stray(p, h->outside.rows[i]);
    for (uint32_t row = first_new; row < h->rows.n; ++row)
        add_if_stray(p, row);
    add_gone(p);
    *even = parts_are_even(p) && are_few(p);
    return true;
}

// ---------------------------------------------------------------- ghosts

static void copy_ghosts(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    const parts *p = context;
    const object_form *form = &p->homes->form;
    (void)thread;
    for (uint64_t i = first; i < end; ++i) {
        const ghost_row *ghost = &p->ghosts[i];
        p->block.rows.ids[i] = ghost->id;
        p->block.keys[i] = ghost->key;
        memcpy(object_row(&p->block.rows, form, (uint32_t)i), ghost->object, form->bytes);
    }
}

// Before any row moves.
static bool fill_block(parts *p, duet_error *err)
{
    uint64_t n = 0, capacity = p->block.rows.capacity;
    for (uint32_t i = 0; i < p->n; ++i) {
        p->list[i].first_ghost = n;
        n += p->list[i].n_ghosts;
    }
    if (!object_rows_reserve(&p->block.rows, &p->homes->form, n, err))
        return false;
    if (!p->block.keys || capacity != p->block.rows.capacity) {
        free(p->block.keys);
        p->block.keys = malloc((p->block.rows.capacity + 1) * sizeof *p->block.keys);
        if (!p->block.keys)
            ghost_block_end(&p->block);
    }
    if (!p->block.keys)
        return no_memory(p, err);
    parallel_each(p->homes->threads, n, copy_ghosts, p);
    return true;
}

// ---------------------------------------------------------------- rows

static bool move_strays(parts *p, homes *h, duet_error *err)
{
    uint32_t *ends = malloc(p->n * sizeof *ends);
    if (!ends)
        return no_memory(p, err);
    for (uint32_t i = 0; i < p->n; ++i)
        ends[i] = p->ranges[i].end;
    bool ok = rows_arrange(&h->rows, &h->form, ends, p->n + 1, p->strays, p->n_strays, err);
    for (uint32_t i = 0; i < p->n; ++i)
        p->ranges[i].end = ends[i];
    for (uint32_t k = 0; ok && k < h->n_gone; ++k)
        h->gone[k] = ends[p->n - 1] + k;
    free(ends);
    count_homes(p);
    return ok;
}

// Behind the last part its ghosts need space.
static bool reserve_behind(const parts *p, homes *h, duet_error *err)
{
    uint64_t most = h->rows.n;
    for (uint32_t i = 0; i < p->n; ++i) {
        uint64_t end = p->ranges[i].end + p->list[i].n_ghosts;
        most = end > most ? end : most;
    }
    return homes_reserve_behind(h, most - h->rows.n, err);
}

bool parts_settle(parts *p, homes *h, parcels *messages, duet_error *err)
{
    parts_forget_ghosts(p);
    p->messages = *messages;
    *messages = (parcels){0};
    p->all_border = h->edges.n;
    bool ok = parts_divide_ghosts(p, err) && fill_block(p, err) && move_strays(p, h, err) &&
              reserve_behind(p, h, err);
    free(p->ghosts);
    p->ghosts = NULL;
    parcels_end(&p->messages);
    homes_forget_renamed(h);
    return ok;
}

// ---------------------------------------------------------------- a part at a time

bool parts_settle_after_walk(parts *p, homes *h, duet_error *err)
{
    bool ok = move_strays(p, h, err);
    homes_forget_renamed(h);
    return ok;
}

sight_in_place parts_sight_in_place(const parts *p, uint32_t part)
{
    const home_part *of = &p->list[part];
    return (sight_in_place){
        .first = first_row(p, part),
        .n = p->ranges[part].end - first_row(p, part),
        .ghost_ids = p->block.rows.ids ? p->block.rows.ids + of->first_ghost : NULL,
        .ghost_keys = p->block.keys ? p->block.keys + of->first_ghost : NULL,
        .n_ghosts = (uint32_t)of->n_ghosts,
        .home = p->rank * p->n + part,
        .n_homes = p->n_ranks * p->n,
    };
}

uint32_t parts_largest(const parts *p)
{
    uint32_t largest = 0;
    for (uint32_t i = 1; i < p->n; ++i)
        largest = p->list[i].n > p->list[largest].n ? i : largest;
    return largest;
}

typedef struct exchange {
    unsigned char *a, *b;
    uint32_t row_bytes;
} exchange;

static void exchange_rows(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    const exchange *e = context;
    unsigned char some[4096];
    (void)thread;
    for (uint64_t at = first * e->row_bytes, to = end * e->row_bytes; at < to; at += sizeof some) {
        size_t n = to - at < sizeof some ? to - at : sizeof some;
        memcpy(some, e->a + at, n);
        memcpy(e->a + at, e->b + at, n);
        memcpy(e->b + at, some, n);
    }
}

static void exchange_ghosts(parts *p, homes *h, uint32_t part)
{
    home_part *of = &p->list[part];
    exchange e = {object_row(&h->rows, &h->form, p->ranges[part].end),
                  object_row(&p->block.rows, &h->form, (uint32_t)of->first_ghost), h->form.bytes};
    parallel_each(h->threads, of->n_ghosts, exchange_rows, &e);
    of->is_open = !of->is_open;
}

void parts_open(parts *p, homes *h, uint32_t part)
{
    if (!p->list[part].is_open)
        exchange_ghosts(p, h, part);
}

void parts_close(parts *p, homes *h, uint32_t part)
{
    if (p->list[part].is_open)
        exchange_ghosts(p, h, part);
}

bool parts_clash(const parts *p, uint32_t a, uint32_t b)
{
    uint64_t end_a = p->ranges[a].end + p->list[a].n_ghosts;
    uint64_t end_b = p->ranges[b].end + p->list[b].n_ghosts;
    return first_row(p, a) < end_b && first_row(p, b) < end_a;
}
