// SPDX-License-Identifier: MIT
#include "cluster/classify.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

typedef struct job {
    owned *o;
    classes *c;
    const interior_block *blocks; // a device's blocks
    uint32_t from;                // the first object that is looked at in the blocks
    atomic_flag adds;             // to o's boxes
} job;

// ---------------------------------------------------------------- one object

static bool holds(const extent *box, const double at[3])
{
    bool inside = true;
    for (int k = 0; k < 3; ++k)
        inside &= (at[k] >= box->lower[k]) & (at[k] < box->upper[k]);
    return inside;
}

// Returns where objects lie so deep in a domain that they touch none of another one.
static extent deep_inside(const owned *o, const domain *d)
{
    extent inside = d->box;
    for (int k = 0; o->placement > PLACED_ANYHOW && k < 3; ++k) {
        inside.lower[k] += 1.01 * o->widest;
        inside.upper[k] -= 1.01 * o->widest;
    }
    return inside;
}

// Returns whether it leaves the rank.
static bool classify_row(const owned *o, class_part *p, const domain *d, const extent *inside,
                         level_boxes *boxes, uint32_t row)
{
    const void *object = object_row(&o->rows, &o->form, row);
    double centre[3];
    if (!object_is_sound(&o->form, object)) {
        p->first_bad = p->first_bad < o->rows.ids[row] ? p->first_bad : o->rows.ids[row];
        ++p->n_bad;
        return false;
    }
    extent e = extent_of(&o->form, object);
    p->widest = fmax(p->widest, extent_widest(&e));
    object_centre(&o->form, object, centre);
    if (extent_holds(inside, centre)) {
        extent_add(&p->deep.centres, centre);
        return false;
    }
    if (o->placement != PLACED_ANYHOW && !holds(&d->box, centre)) {
        row_list_add(&p->leavers, row);
        return true;
    }
    level_boxes_add(boxes, &e, o->widest);
    row_list_add(&p->boundary, row);
    return false;
}

static void add_boxes(job *j, uint32_t d, const level_boxes *boxes)
{
    while (atomic_flag_test_and_set(&j->adds))
        continue;
    for (int k = 0; k < SIZE_LEVELS; ++k)
        extent_join(&j->o->boxes[d].upto[k], &boxes->upto[k]);
    atomic_flag_clear(&j->adds);
}

// ---------------------------------------------------------------- by the host

static uint32_t domain_of(const owned *o, uint32_t row)
{
    double centre[3];
    if (o->n_domains == 1)
        return 0;
    object_row_centre(&o->rows, &o->form, row, centre);
    return owned_domain_at(o, centre);
}

static void add_run(const owned *o, class_part *p, uint32_t d, uint32_t first, uint32_t end)
{
    if (o->n_domains > 1 && first < end)
        run_list_add(&p->runs, (row_run){.domain = d, .first = first, .n = end - first});
}

// Classifies rows from `first` on, up to one that lies in another domain. Returns that one.
static uint32_t classify_stretch(job *j, class_part *p, uint32_t first, uint32_t end)
{
    const owned *o = j->o;
    const uint32_t d = domain_of(o, first);
    const extent inside = deep_inside(o, &o->domains[d]);
    uint64_t n_boundary = p->boundary.n;
    level_boxes boxes;
    level_boxes_clear(&boxes);
    uint32_t row = first;
    while ((row = object_rows_add_interior(&o->rows, &o->form, row, end, &inside, &p->deep)) <
               end &&
           domain_of(o, row) == d) {
        if (classify_row(o, p, &o->domains[d], &inside, &boxes, row)) {
            add_run(o, p, d, first, row);
            first = row + 1;
        }
        ++row;
    }
    add_run(o, p, d, first, row);
    if (p->boundary.n > n_boundary)
        add_boxes(j, d, &boxes);
    return row;
}

static void classify_rows(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    job *j = context;
    class_part p = j->c->parts[part]; // apart from what other threads write
    for (uint32_t row = (uint32_t)first; row < end;)
        row = classify_stretch(j, &p, row, (uint32_t)end);
    p.widest = fmax(p.widest, interior_widest(&p.deep, &j->o->form));
    j->c->parts[part] = p;
}

// ---------------------------------------------------------------- by a device

// Looks at the objects that a device found exceptional.
static void classify_odd(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    job *j = context;
    const owned *o = j->o;
    class_part p = j->c->parts[part];
    const extent inside = deep_inside(o, &o->domains[0]);
    level_boxes boxes;
    level_boxes_clear(&boxes);
    for (uint64_t i = j->from + first; i < j->from + end;) {
        const interior_block *b = &j->blocks[i / INTERIOR_ROWS];
        uint32_t odd = b->odd[i % INTERIOR_ROWS / 32] >> i % 32;
        if (odd & 1)
            classify_row(o, &p, &o->domains[0], &inside, &boxes, (uint32_t)i);
        uint32_t passed = b->n_odd == 0 ? INTERIOR_ROWS - 1 : odd > 1 ? 0 : 31;
        i = (i | passed) + 1;
    }
    add_boxes(j, 0, &boxes);
    j->c->parts[part] = p;
}

// The host looks at objects that have arrived there while others travel. False if rows are not on
// their way to a device, or to one that does not classify.
static bool classify_on_device(job *j)
{
    owned *o = j->o;
    worker *w = o->holder;
    const extent inside = deep_inside(o, &o->domains[0]);
    float lower[3], upper[3];
    interior_box(&inside, lower, upper);
    if (!w || o->rows.n == 0 || o->placement != PLACED_BY_DOMAIN ||
        !w->find_interior(w, lower, upper))
        return false;
    for (uint32_t from = 0, to; from < o->rows.n; from = to) {
        to = w->await_interior(w, from, &j->blocks);
        j->from = from;
        parallel_each(o->threads, to - from, classify_odd, j);
        for (uint32_t i = from; i < to; i += INTERIOR_ROWS)
            interior_add_block(&j->c->deep, &j->blocks[i / INTERIOR_ROWS]);
    }
    j->c->widest = interior_widest(&j->c->deep, &o->form);
    return true;
}

// ---------------------------------------------------------------- all

static void begin(class_part *p)
{
    p->n_bad = 0;
    p->first_bad = UINT64_MAX;
    p->widest = 0;
    p->deep = interior_none;
    list_clear(&p->leavers.list);
    list_clear(&p->boundary.list);
    list_clear(&p->runs.list);
}

static void add_part(classes *c, owned *o, const class_part *p)
{
    c->n_bad += p->n_bad;
    c->first_bad = c->first_bad < p->first_bad ? c->first_bad : p->first_bad;
    c->widest = fmax(c->widest, p->widest);
    extent_join(&c->deep.centres, &p->deep.centres);
    list_append(&c->leavers.list, &p->leavers.list, sizeof *c->leavers.rows);
    list_append(&o->boundary.list, &p->boundary.list, sizeof *o->boundary.rows);
    list_append(&o->runs.list, &p->runs.list, sizeof *o->runs.runs);
}

static extent around_all(const owned *o, const extent *deep)
{
    extent all = extent_none;
    for (uint32_t d = 0; d < o->n_domains; ++d)
        for (int k = 0; k < SIZE_LEVELS; ++k)
            extent_join(&all, &o->boxes[d].upto[k]);
    for (int k = 0; k < 3 && deep->lower[0] <= deep->upper[0]; ++k) {
        all.lower[k] = fmin(all.lower[k], deep->lower[k] - 0.5 * o->widest);
        all.upper[k] = fmax(all.upper[k], deep->upper[k] + 0.5 * o->widest);
    }
    return all;
}

bool classify(classes *c, owned *o)
{
    job j = {.o = o, .c = c, .adds = ATOMIC_FLAG_INIT};
    c->n_bad = 0;
    c->first_bad = UINT64_MAX;
    c->widest = 0;
    c->deep = interior_none;
    list_clear(&c->leavers.list);
    list_clear(&o->boundary.list);
    list_clear(&o->runs.list);
    for (int i = 0; i < PARALLEL_MOST; ++i)
        begin(&c->parts[i]);
    for (uint32_t d = 0; d < o->most_domains; ++d)
        level_boxes_clear(&o->boxes[d]);
    if (!classify_on_device(&j))
        parallel_each(o->threads, o->rows.n, classify_rows, &j);
    for (int i = 0; i < PARALLEL_MOST; ++i)
        add_part(c, o, &c->parts[i]);
    if (j.blocks)
        row_list_sort(&c->leavers);
    o->around = around_all(o, &c->deep.centres);
    return !c->leavers.failed && !o->boundary.failed && !o->runs.failed;
}

void classes_end(classes *c)
{
    for (int i = 0; i < PARALLEL_MOST; ++i) {
        free(c->parts[i].leavers.rows);
        free(c->parts[i].boundary.rows);
        free(c->parts[i].runs.runs);
    }
    free(c->leavers.rows);
    *c = (classes){0};
}
