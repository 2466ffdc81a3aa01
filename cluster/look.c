// SPDX-License-Identifier: MIT
#include "cluster/look.h"

#include <math.h>
#include <stdatomic.h>

static void forget(glance *g)
{
    row_list leavers = g->leavers, border = g->border, edges = g->edges, outside = g->outside;
    *g = (glance){.first_bad = UINT64_MAX, .deep = skim_none};
    g->leavers = (row_list){.rows = leavers.rows, .capacity = leavers.capacity};
    g->border = (row_list){.rows = border.rows, .capacity = border.capacity};
    g->edges = (row_list){.rows = edges.rows, .capacity = edges.capacity};
    g->outside = (row_list){.rows = outside.rows, .capacity = outside.capacity};
    for (int l = 0; l < LEVELS; ++l)
        g->boxes.upto[l] = reach_none;
}

static bool is_inside(const reach *inside, const double at[3])
{
    bool deep = true;
    for (int k = 0; k < 3; ++k)
        deep &= (at[k] > inside->lower[k]) & (at[k] < inside->upper[k]);
    return deep;
}

// What has come a little way out of a range's box touches homes at edges only.
static void look_where(const look *l, glance *g, uint32_t i, const double centre[3])
{
    const reach *box = &l->h->ranges[l->range].box;
    double far = 0;
    if (!l->copies || is_inside(box, centre))
        return;
    row_list_add(&g->outside, i);
    for (int k = 0; k < 3; ++k)
        far = fmax(far, fmax(box->lower[k] - centre[k], centre[k] - box->upper[k]));
    g->leapt |= far > l->h->widest;
}

static void look_closely(const look *l, glance *g, uint32_t i)
{
    const homes *h = l->h;
    const void *object = object_row(&h->rows, &h->form, i);
    if (!object_is_sound(&h->form, object)) {
        g->first_bad = g->first_bad < h->rows.ids[i] ? g->first_bad : h->rows.ids[i];
        ++g->bad;
        return;
    }
    reach e = reach_of(&h->form, object);
    double width = reach_widest(&e);
    double centre[3];
    g->widest = fmax(g->widest, width);
    object_centre(&h->form, object, centre);
    if (h->is_cut && !cut_keeps(l->c, centre)) {
        row_list_add(&g->leavers, i);
        return;
    }
    if (h->n_ranges > 0) {
        row_list_add(&g->edges, i);
        look_where(l, g, i, centre);
        if (is_inside(&l->inside, centre)) {
            reach_add(&g->deep.centres, &(reach){{centre[0], centre[1], centre[2]},
                                                 {centre[0], centre[1], centre[2]}});
            return;
        }
    }
    reach_add(&g->boxes.upto[level_of(width, h->widest)], &e);
    row_list_add(&g->border, i);
}

// Where homes lie so many times their width deep in a box.
static reach deep_inside(const reach *box, double widths)
{
    reach inside = *box;
    for (int k = 0; k < 3; ++k) {
        inside.lower[k] += 1.01 * widths;
        inside.upper[k] -= 1.01 * widths;
    }
    return inside;
}

static reach both(const reach *a, const reach *b)
{
    reach inside = *a;
    for (int k = 0; k < 3; ++k) {
        inside.lower[k] = fmax(inside.lower[k], b->lower[k]);
        inside.upper[k] = fmin(inside.upper[k], b->upper[k]);
    }
    return inside;
}

// Where homes lie so deep in the box of a range, too, that they touch none of another one.
static reach inside_of_range(const look *l, uint32_t range)
{
    if (range == l->h->n_ranges)
        return reach_none;
    reach inside = deep_inside(&l->h->ranges[range].box, l->h->widest);
    return both(&inside, &l->inside);
}

static void look_along(const look *l, glance *g, uint32_t i, uint32_t to, const reach *inside)
{
    const homes *h = l->h;
    while ((i = object_rows_skim(&h->rows, &h->form, i, to, inside, &g->deep)) < to)
        look_closely(l, g, i++);
}

static void look_at_ranges(const look *l, glance *g, uint32_t i, uint32_t to)
{
    const homes *h = l->h;
    for (uint32_t range = 0; i < to; ++range) {
        uint32_t end = range < h->n_ranges ? h->ranges[range].end : to;
        end = end < to ? end : to;
        if (end <= i)
            continue;
        reach inside = inside_of_range(l, range);
        look_along(l, g, i, end, &inside);
        i = end;
    }
}

static void look_at_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    look *l = context;
    const homes *h = l->h;
    glance g = l->parts[part]; // apart from what other threads write
    if (h->n_ranges > 0)
        look_at_ranges(l, &g, (uint32_t)first, (uint32_t)end);
    else
        look_along(l, &g, (uint32_t)first, (uint32_t)end, &l->inside);
    g.widest = fmax(g.widest, skim_widest(&g.deep, &h->form));
    l->parts[part] = g;
}

// The edges that a thread has found since, while it has their rows at hand.
static void copy_edges(const look *l, const row_list *edges, uint64_t since)
{
    const homes *h = l->h;
    edge_rows *to = l->copies;
    uint64_t n = edges->failed ? 0 : edges->n - since, at = atomic_fetch_add(&to->n, n);
    if (at + n > to->rows.capacity)
        return;
    object_rows_gather(&to->rows, &h->form, at, &h->rows, edges->rows + since, n);
    for (uint64_t i = at; i < at + n; ++i)
        to->ranges[i] = (uint16_t)l->range;
}

// Of objects from l->first on those that the device found odd.
static void look_at_odd(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    look *l = context;
    glance g = l->parts[part];
    uint64_t since = g.edges.n;
    for (uint64_t i = l->first + first; i < l->first + end;) {
        const skim_block *b = &l->blocks[i / SKIM_ROWS];
        uint32_t odd = b->odd[i % SKIM_ROWS / 32] >> i % 32;
        if (odd & 1)
            look_closely(l, &g, l->base + (uint32_t)i);
        uint32_t passed = b->n_odd == 0 ? SKIM_ROWS - 1 : odd > 1 ? 0 : 31;
        i = (i | passed) + 1;
    }
    if (l->copies)
        copy_edges(l, &g.edges, since);
    l->parts[part] = g;
}

static void add_glance(glance *to, const glance *g)
{
    to->bad += g->bad;
    to->first_bad = to->first_bad < g->first_bad ? to->first_bad : g->first_bad;
    to->widest = fmax(to->widest, g->widest);
    to->leavers.n += g->leavers.n;
    to->leavers.failed |= g->leavers.failed;
    to->border.n += g->border.n;
    to->border.failed |= g->border.failed;
    to->edges.n += g->edges.n;
    to->edges.failed |= g->edges.failed;
    to->outside.n += g->outside.n;
    to->outside.failed |= g->outside.failed;
    to->leapt |= g->leapt;
    reach_add(&to->deep.centres, &g->deep.centres);
    for (int k = 0; k < LEVELS; ++k)
        reach_add(&to->boxes.upto[k], &g->boxes.upto[k]);
}

// Homes that are on their way to a device are skimmed there, and the host looks at the odd ones of
// those that have arrived while others travel. False where the device does not.
static bool look_with(look *l, worker *w, uint32_t n, const reach *inside)
{
    float lower[3], upper[3];
    skim_box(inside, lower, upper);
    if (!w || !w->skim || n == 0 || !w->skim(w, lower, upper))
        return false;
    for (uint32_t from = 0, to; from < n; from = to) {
        to = w->await_skim(w, from, &l->blocks);
        l->first = from;
        parallel_each(l->h->threads, to - from, look_at_odd, l);
        for (uint32_t i = from; i < to; i += SKIM_ROWS)
            skim_add_block(&l->all.deep, &l->blocks[i / SKIM_ROWS]);
    }
    return true;
}

bool look_at_range(look *l, uint32_t range, worker *w, edge_rows *copies)
{
    const homes *h = l->h;
    const reach rank = cut_box(l->c);
    reach inside = both(&rank, &h->ranges[range].box);
    inside = deep_inside(&inside, 2 * h->widest);
    l->base = range > 0 ? h->ranges[range - 1].end : 0;
    l->range = range;
    l->copies = copies;
    uint32_t n = h->ranges[range].end - l->base;
    return n == 0 || look_with(l, w, n, &inside);
}

static void begin(look *l)
{
    homes *h = l->h;
    for (int i = 0; i < PARALLEL_MOST; ++i)
        forget(&l->parts[i]);
    forget(&l->all);
    l->blocks = NULL;
    l->copies = NULL;
    l->base = 0;
    l->inside = reach_none;
    if (h->is_cut && h->widest > 0) {
        const reach rank = cut_box(l->c);
        l->inside = deep_inside(&rank, h->widest);
    }
}

static void end(look *l)
{
    if (l->blocks)
        l->all.widest = skim_widest(&l->all.deep, &l->h->form);
    for (int i = 0; i < PARALLEL_MOST; ++i)
        add_glance(&l->all, &l->parts[i]);
}

void look_at_rows(look *l)
{
    begin(l);
    parallel_each(l->h->threads, l->h->rows.n, look_at_part, l);
    end(l);
}

void look_at_all(look *l)
{
    homes *h = l->h;
    h->walked = false;
    begin(l);
    bool done = h->n_ranges == 0 ? look_with(l, h->holder, h->rows.n, &l->inside)
                                 : h->walk && h->walk(h->walk_context, l);
    if (done)
        end(l);
    else
        look_at_rows(l);
    h->walked = done && h->n_ranges > 0;
}
