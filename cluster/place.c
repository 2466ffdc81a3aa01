// SPDX-License-Identifier: MIT
// Placing: the rows of a rank are divided among its domains, and put in the order in which their
// worker searches them best.
#include "cluster/owned.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLE_A_DOMAIN = 1 << 12 };

// ---------------------------------------------------------------- domains

static bool make_planes(owned *o, duet_error *err)
{
    uint64_t most = (uint64_t)SAMPLE_A_DOMAIN * o->n_domains;
    bisection_point *sample = malloc(most * sizeof *sample);
    if (!sample)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", o->n_domains);
    uint32_t n = partition_sample(sample, most, &o->form, &o->rows);
    bisection_cut(&o->planes, NULL, sample, n);
    free(sample);
    return true;
}

// Domains [first, end) that have rows [row, end_row) together.
typedef struct span {
    uint32_t first, end;
    uint32_t row, end_row;
} span;

typedef struct sorting {
    owned *o;
    const span *from; // the spans to halve
    span *to;         // two halves of each
} sorting;

static void exchange_rows(owned *o, uint32_t a, uint32_t b)
{
    unsigned char object[sizeof(duet_large_pose)];
    uint64_t id = o->rows.ids[a];
    memcpy(object, object_row(&o->rows, &o->form, a), o->form.bytes);
    object_rows_gather(&o->rows, &o->form, a, &o->rows, &b, 1);
    o->rows.ids[b] = id;
    memcpy(object_row(&o->rows, &o->form, b), object, o->form.bytes);
}

static bool lies_below(const owned *o, const bisection_plane *plane, uint32_t row)
{
    double centre[3];
    object_row_centre(&o->rows, &o->form, row, centre);
    return centre[plane->axis] < plane->at;
}

// Brings the rows of a span to the lower and the upper half of its domains, from both ends on.
static void halve(void *context, uint32_t job, uint64_t unused_first, uint64_t unused_end)
{
    const sorting *s = context;
    owned *o = s->o;
    span all = s->from[job], *halves = s->to + 2 * job;
    uint32_t middle = all.first + (all.end - all.first) / 2, i = all.row, k = all.end_row;
    const bisection_plane *plane = &o->planes.planes[middle];
    (void)unused_first, (void)unused_end;
    if (all.end - all.first < 2) {
        halves[0] = all;
        halves[1] = (span){all.end, all.end, all.end_row, all.end_row};
        return;
    }
    for (;;) {
        while (i < k && lies_below(o, plane, i))
            ++i;
        while (i < k && !lies_below(o, plane, k - 1))
            --k;
        if (i == k)
            break;
        exchange_rows(o, i++, --k);
    }
    halves[0] = (span){all.first, middle, all.row, i};
    halves[1] = (span){middle, all.end, i, all.end_row};
}

// Halves the rows by the planes, all spans of domains at once, until each span is one domain.
// spans, [8 n_domains], then begins with them, and with empty ones; returns how many there are.
static uint32_t sort_rows(owned *o, span *spans)
{
    uint32_t n = 1;
    span *next = spans + 4 * (size_t)o->n_domains;
    spans[0] = (span){0, o->n_domains, 0, o->rows.n};
    for (; n < o->n_domains; n *= 2) {
        for (uint32_t from = 0; from < n; from += PARALLEL_MOST) {
            sorting s = {o, spans + from, next + 2 * (size_t)from};
            parallel_jobs(o->threads, n - from < PARALLEL_MOST ? n - from : PARALLEL_MOST, halve,
                          &s);
        }
        memcpy(spans, next, 2 * (size_t)n * sizeof *spans);
    }
    return n;
}

// ---------------------------------------------------------------- the order within a domain

typedef struct reordering {
    owned *o;
    uint32_t first;
    object_rows copy;
    uint32_t *order;
    void *scratch;
} reordering;

static void put_in_order(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    reordering *r = context;
    (void)part;
    object_rows_gather(&r->o->rows, &r->o->form, r->first + first, &r->copy, r->order + first,
                       end - first);
}

static bool order_rows(owned *o, uint32_t first, uint32_t n, worker *w, duet_error *err)
{
    reordering r = {.o = o, .first = first};
    if (n == 0)
        return true;
    r.copy.ids = malloc(n * sizeof *r.copy.ids);
    r.order = malloc(n * sizeof *r.order);
    r.scratch = malloc((size_t)n * WORKER_ORDER_SCRATCH);
    bool ok = (r.copy.ids && r.order && r.scratch) ||
              error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " objects: no memory", n);
    r.copy.objects = ok ? w->map(w, n, err) : NULL;
    ok = ok && r.copy.objects;
    if (ok) {
        parallel_copy(o->threads, r.copy.ids, o->rows.ids + first, n, sizeof *r.copy.ids);
        parallel_copy(o->threads, r.copy.objects, object_row(&o->rows, &o->form, first), n,
                      o->form.bytes);
        ok = w->order(w, o->threads->n, r.order, r.scratch, err);
    }
    if (ok)
        parallel_each(o->threads, n, put_in_order, &r);
    free(r.scratch);
    free(r.order);
    free(r.copy.ids);
    return ok;
}

// Moves the rows to the worker's memory.
static bool move_in(owned *o, worker *w, duet_error *err)
{
    void *objects = w->extend(w, o->rows.n, 0, err);
    if (!objects)
        return false;
    parallel_copy(o->threads, objects, o->rows.objects, o->rows.n, o->form.bytes);
    free(o->rows.objects);
    o->rows.objects = objects;
    o->holder = w;
    o->renamed.failed = true;
    return true;
}

// Brings the rows of each domain together, in the order that suits its worker.
static bool place_rows(owned *o, worker *const workers[2], duet_error *err)
{
    span *spans = malloc(8 * (size_t)o->n_domains * sizeof *spans);
    bool ok = spans ||
              error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", o->n_domains);
    uint32_t n = ok ? sort_rows(o, spans) : 0, most = 0;
    for (uint32_t i = 0; ok && i < n; ++i) {
        uint32_t d = spans[i].first, own = spans[i].end_row - spans[i].row;
        worker *w = workers[d % 2];
        if (own == 0)
            continue;
        most = own > most ? own : most;
        ok = w->use_grid(w, d, err) && order_rows(o, spans[i].row, own, w, err);
    }
    free(spans);
    o->unevenness = o->rows.n > 0 ? fmax(1, (double)most * o->n_domains / o->rows.n) : 1;
    return ok;
}

bool owned_place(owned *o, const extent *box, worker *const workers[2], duet_error *err)
{
    o->placement = PLACED_BY_RANK;
    owned_forget_domains(o);
    o->domains[0].box = *box;
    if ((o->n_domains > 1 && !make_planes(o, err)) ||
        (!o->holder && !place_rows(o, workers, err)) ||
        (o->n_domains == 1 && !o->holder && !move_in(o, workers[0], err)))
        return false;
    for (uint32_t d = 0; d < o->n_domains; ++d)
        o->domains[d].box = bisection_box(&o->planes, d, box);
    o->placement = PLACED_BY_DOMAIN;
    o->fitted = (extent){0};
    return true;
}
