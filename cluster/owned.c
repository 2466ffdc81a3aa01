// SPDX-License-Identifier: MIT
#include "cluster/owned.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- begin and end

bool owned_begin(owned *o, uint32_t n_domains, uint32_t most_domains, parallel *threads,
                 duet_error *err)
{
    *o = (owned){.n_domains = n_domains, .most_domains = most_domains, .threads = threads};
    o->domains = calloc(n_domains, sizeof *o->domains);
    o->boxes = calloc(most_domains, sizeof *o->boxes);
    return ((o->domains && o->boxes) || no_memory(err, "%" PRIu32 " parts", n_domains)) &&
           bisection_begin(&o->planes, n_domains, err);
}

void owned_forget_domains(owned *o)
{
    for (uint32_t d = 0; d < o->n_domains; ++d)
        o->domains[d] = (domain){.box = d == 0 ? extent_all : extent_none};
}

static void release(owned *o)
{
    if (o->holder)
        o->rows.objects = NULL;
    object_rows_end(&o->rows);
    o->holder = NULL;
    o->leavers.n = 0;
}

void owned_take(owned *o, object_rows *rows)
{
    release(o);
    o->rows = *rows;
    o->widest = 0;
    o->fitted = (extent){0};
    o->placement = PLACED_ANYHOW;
    *rows = (object_rows){0};
    owned_forget_domains(o);
}

void owned_end(owned *o)
{
    release(o);
    bisection_end(&o->planes);
    free(o->domains);
    free(o->boxes);
    free(o->leavers.rows);
    free(o->boundary.rows);
    free(o->renamed.rows);
    free(o->runs.runs);
    *o = (owned){0};
}

void owned_forget_renamed(owned *o)
{
    list_clear(&o->renamed.list);
}

// ---------------------------------------------------------------- rows

static bool reserve_ids(owned *o, uint64_t n, duet_error *err)
{
    if (o->rows.ids && n <= o->rows.capacity)
        return true;
    uint64_t capacity = n + n / 16;
    uint64_t *ids = realloc(o->rows.ids, (capacity + 1) * sizeof *ids);
    o->rows.ids = ids ? ids : o->rows.ids;
    void *objects =
        o->holder || !ids ? NULL : realloc(o->rows.objects, (size_t)(capacity + 1) * o->form.bytes);
    o->rows.objects = objects ? objects : o->rows.objects;
    if (!ids || (!o->holder && !objects))
        return no_memory(err, "%" PRIu64 " objects", n);
    o->rows.capacity = capacity;
    return true;
}

bool owned_map(owned *o, duet_error *err)
{
    if (!o->holder)
        return true;
    void *objects = o->holder->map(o->holder, o->rows.n, err);
    o->rows.objects = objects ? objects : o->rows.objects;
    return objects;
}

bool owned_reserve(owned *o, uint64_t more, duet_error *err)
{
    uint64_t n = o->rows.n + more;
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%" PRIu64 " objects and ghosts on one rank; expected more ranks", n);
    if (!reserve_ids(o, n, err))
        return false;
    if (!o->holder)
        return true;
    void *objects = o->holder->extend(o->holder, (uint32_t)n, o->rows.n, err);
    o->rows.objects = objects ? objects : o->rows.objects;
    return objects;
}

// ---------------------------------------------------------------- leavers and newcomers

// Begins with the last leaver, so that no leaver takes another one's row.
void owned_tidy(owned *o)
{
    for (uint64_t k = o->leavers.n; k-- > 0;) {
        uint32_t gap = o->leavers.rows[k], last = --o->rows.n;
        if (gap == last)
            continue;
        object_rows_gather(&o->rows, &o->form, gap, &o->rows, &last, 1);
        if (o->holder)
            row_list_add(&o->renamed, gap);
    }
    o->leavers.n = 0;
}

typedef struct writing {
    owned *o;
    const parcels *messages;
} writing;

static void write_messages(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const writing *w = context;
    const unsigned char *from = w->messages->rows;
    object_rows to = w->o->rows;
    (void)part;
    to.n += (uint32_t)first;
    for (uint64_t i = first; i < end; ++i) {
        const unsigned char *message = from + i * w->messages->row_bytes;
        uint64_t id;
        memcpy(&id, message, sizeof id);
        object_rows_append(&to, &w->o->form, &id, message + sizeof id, 1);
    }
}

bool owned_add_newcomers(owned *o, const parcels *messages, duet_error *err)
{
    if (!owned_reserve(o, messages->n, err))
        return false;
    writing w = {o, messages};
    parallel_each(o->threads, messages->n, write_messages, &w);
    o->rows.n += (uint32_t)messages->n;
    return true;
}

// ---------------------------------------------------------------- domains

static double unevenness_of(const owned *o)
{
    uint64_t most = 0, n = 0;
    for (uint32_t d = 0; d < o->n_domains; ++d) {
        n += o->domains[d].n;
        most = o->domains[d].n > most ? o->domains[d].n : most;
    }
    return n > 0 ? (double)most * o->n_domains / (double)n : 1;
}

bool owned_is_uneven(const owned *o)
{
    return unevenness_of(o) > 1.2 * o->unevenness;
}

// ---------------------------------------------------------------- runs

bool owned_sort_runs(owned *o, duet_error *err)
{
    run_list *l = &o->runs;
    uint64_t capacity = l->n + 1, before = 0;
    row_run *sorted = l->failed ? NULL : malloc(capacity * sizeof *sorted);
    if (!sorted)
        return no_memory(err, "%" PRIu64 " runs of objects", l->n);
    for (uint32_t d = 0; d < o->n_domains; ++d)
        o->domains[d].n = o->domains[d].n_runs = 0;
    for (uint64_t i = 0; i < l->n; ++i)
        ++o->domains[l->runs[i].domain].n_runs;
    for (uint32_t d = 0; d < o->n_domains; ++d) {
        o->domains[d].run = before;
        before += o->domains[d].n_runs;
        o->domains[d].n_runs = 0;
    }
    for (uint64_t i = 0; i < l->n; ++i) {
        domain *d = &o->domains[l->runs[i].domain];
        row_run *run = &sorted[d->run + d->n_runs++];
        *run = l->runs[i];
        run->at = d->n;
        d->n += run->n;
    }
    free(l->runs);
    l->runs = sorted;
    l->capacity = capacity;
    return true;
}

// ---------------------------------------------------------------- rows of each domain

enum { SAMPLE_A_DOMAIN = 1 << 12 };

static bool make_planes(owned *o, duet_error *err)
{
    uint64_t most = (uint64_t)SAMPLE_A_DOMAIN * o->n_domains;
    bisection_point *sample = malloc(most * sizeof *sample);
    if (!sample)
        return no_memory(err, "%" PRIu32 " parts", o->n_domains);
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
    bool ok = (r.copy.ids && r.order && r.scratch) || no_memory(err, "%" PRIu32 " objects", n);
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
    bool ok = spans || no_memory(err, "%" PRIu32 " parts", o->n_domains);
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
