// SPDX-License-Identifier: MIT
#include "cluster/look.h"

#include <math.h>

static void forget(glance *g)
{
    row_list leavers = g->leavers, border = g->border, edges = g->edges;
    *g = (glance){.first_bad = UINT64_MAX, .deep = skim_none};
    g->leavers = (row_list){.rows = leavers.rows, .capacity = leavers.capacity};
    g->border = (row_list){.rows = border.rows, .capacity = border.capacity};
    g->edges = (row_list){.rows = edges.rows, .capacity = edges.capacity};
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
        if (is_inside(&l->inside, centre)) {
            reach_add(&g->deep.centres, &(reach){{centre[0], centre[1], centre[2]},
                                                 {centre[0], centre[1], centre[2]}});
            return;
        }
    }
    reach_add(&g->boxes.upto[level_of(width, h->widest)], &e);
    row_list_add(&g->border, i);
}

// Where homes lie so deep in the box of a range, too, that they touch none of another one.
static reach inside_of_range(const look *l, uint32_t range)
{
    reach inside = l->inside;
    if (range == l->h->n_ranges)
        return reach_none;
    const reach *box = &l->h->ranges[range].box;
    for (int k = 0; k < 3; ++k) {
        inside.lower[k] = fmax(inside.lower[k], box->lower[k] + 1.01 * l->h->widest);
        inside.upper[k] = fmin(inside.upper[k], box->upper[k] - 1.01 * l->h->widest);
    }
    return inside;
}

static void look_at_rows(const look *l, glance *g, uint32_t i, uint32_t to, const reach *inside)
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
        look_at_rows(l, g, i, end, &inside);
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
        look_at_rows(l, &g, (uint32_t)first, (uint32_t)end, &l->inside);
    g.widest = fmax(g.widest, skim_widest(&g.deep, &h->form));
    l->parts[part] = g;
}

// Of rows from l->first on those that the device found odd.
static void look_at_odd(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    look *l = context;
    glance g = l->parts[part];
    for (uint64_t i = l->first + first; i < l->first + end;) {
        const skim_block *b = &l->blocks[i / SKIM_ROWS];
        uint32_t odd = b->odd[i % SKIM_ROWS / 32] >> i % 32;
        if (odd & 1)
            look_closely(l, &g, (uint32_t)i);
        uint32_t passed = b->n_odd == 0 ? SKIM_ROWS - 1 : odd > 1 ? 0 : 31;
        i = (i | passed) + 1;
    }
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
    reach_add(&to->deep.centres, &g->deep.centres);
    for (int k = 0; k < LEVELS; ++k)
        reach_add(&to->boxes.upto[k], &g->boxes.upto[k]);
}

// Homes that are on their way to a device are skimmed there, and the host looks at the odd ones of
// those that have arrived while others travel. False where the device does not.
static bool look_with_device(look *l)
{
    homes *h = l->h;
    worker *w = h->holder;
    float lower[3], upper[3];
    skim_box(&l->inside, lower, upper);
    if (!w || !w->skim || h->rows.n == 0 || !w->skim(w, lower, upper))
        return false;
    for (uint32_t from = 0, to; from < h->rows.n; from = to) {
        to = w->await_skim(w, from, &l->blocks);
        l->first = from;
        parallel_each(h->threads, to - from, look_at_odd, l);
        for (uint32_t i = from; i < to; i += SKIM_ROWS)
            skim_add_block(&l->all.deep, &l->blocks[i / SKIM_ROWS]);
    }
    l->all.widest = skim_widest(&l->all.deep, &h->form);
    return true;
}

void look_at_all(look *l)
{
    homes *h = l->h;
    for (int i = 0; i < PARALLEL_MOST; ++i)
        forget(&l->parts[i]);
    forget(&l->all);
    l->blocks = NULL;
    l->inside = reach_none;
    for (int k = 0; k < 3 && h->is_cut && h->widest > 0; ++k) {
        l->inside.lower[k] = l->c->lower[k] + 1.01 * h->widest;
        l->inside.upper[k] = l->c->upper[k] - 1.01 * h->widest;
    }
    if (!look_with_device(l))
        parallel_each(h->threads, h->rows.n, look_at_part, l);
    for (int i = 0; i < PARALLEL_MOST; ++i)
        add_glance(&l->all, &l->parts[i]);
}
