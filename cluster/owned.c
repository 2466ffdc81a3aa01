// SPDX-License-Identifier: MIT
#include "cluster/owned.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_AT_ONCE = 1 << 20, SAMPLE_A_DOMAIN = 1 << 12 };

#define NONE_BOXED                          \
    {                                       \
        {INFINITY, INFINITY, INFINITY},     \
        {                                   \
            -INFINITY, -INFINITY, -INFINITY \
        }                                   \
    }
#define FOUR_NONE NONE_BOXED, NONE_BOXED, NONE_BOXED, NONE_BOXED

_Static_assert(LEVELS == 16, "as many as are listed here");
const level_boxes level_boxes_none = {{FOUR_NONE, FOUR_NONE, FOUR_NONE, FOUR_NONE}};

static const extent everywhere = {{-INFINITY, -INFINITY, -INFINITY},
                                  {INFINITY, INFINITY, INFINITY}};

void level_boxes_add(level_boxes *boxes, const extent *e, double widest)
{
    extent_join(&boxes->upto[level_of(extent_widest(e), widest)], e);
}

// ---------------------------------------------------------------- begin and end

bool owned_begin(owned *o, uint32_t n_domains, uint32_t most_domains, parallel *threads,
                 duet_error *err)
{
    *o = (owned){.n_domains = n_domains, .most_domains = most_domains, .threads = threads};
    o->domains = calloc(n_domains, sizeof *o->domains);
    o->boxes = calloc(most_domains, sizeof *o->boxes);
    return ((o->domains && o->boxes) ||
            error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", n_domains)) &&
           bisection_begin(&o->planes, n_domains, err);
}

void owned_forget_domains(owned *o)
{
    memset(o->domains, 0, o->n_domains * sizeof *o->domains);
    o->domains[0] = (domain){.box = everywhere, .n = o->rows.n, .first_new = o->rows.n};
    for (uint32_t d = 1; d < o->n_domains; ++d)
        o->domains[d] = (domain){.box = extent_none, .first = o->rows.n, .first_new = o->rows.n};
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
    *o = (owned){0};
}

void owned_forget_renamed(owned *o)
{
    o->renamed = (row_list){.rows = o->renamed.rows, .capacity = o->renamed.capacity};
}

static bool no_memory(uint64_t n, duet_error *err)
{
    return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
}

// ---------------------------------------------------------------- rows

static void move_rows(owned *o, uint32_t to, uint32_t from, uint32_t n)
{
    memmove(o->rows.ids + to, o->rows.ids + from, n * sizeof *o->rows.ids);
    memmove(object_row(&o->rows, &o->form, to), object_row(&o->rows, &o->form, from),
            (size_t)n * o->form.bytes);
}

static void add_renamed(owned *o, uint32_t row, uint32_t n)
{
    for (uint32_t i = 0; o->holder && i < n; ++i)
        row_list_add(&o->renamed, row + i);
}

uint32_t owned_domain_of(const owned *o, uint32_t row)
{
    bool is_new = row >= o->domains[0].first_new;
    uint32_t d = 0, end = o->n_domains;
    while (end - d > 1) {
        uint32_t middle = d + (end - d) / 2;
        const domain *at = &o->domains[middle];
        if ((is_new ? at->first_new : at->first) <= row)
            d = middle;
        else
            end = middle;
    }
    return d;
}

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
        return no_memory(n, err);
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

// ---------------------------------------------------------------- tidying

// Fills the rows of leavers with the last rows of their domains, from the last leaver on, so that
// no leaver takes another one's row.
static void close_gaps(owned *o)
{
    uint32_t d = o->n_domains;
    for (uint64_t k = o->leavers.n; k-- > 0;) {
        uint32_t gap = o->leavers.rows[k];
        while (d == o->n_domains || gap < o->domains[d].first)
            --d;
        uint32_t last = o->domains[d].first + --o->domains[d].n;
        if (gap != last) {
            move_rows(o, gap, last, 1);
            add_renamed(o, gap, 1);
        }
    }
    o->leavers.n = 0;
}

// Fills the gap behind the only domain that has rows with the last newcomers.
static void join_newcomers(owned *o)
{
    domain *d = &o->domains[0];
    uint32_t gap = d->first_new - d->n, n = gap < d->n_new ? gap : d->n_new;
    move_rows(o, d->n, d->first_new + d->n_new - n, n);
    add_renamed(o, d->n, n);
    d->n += d->n_new;
}

static void move_domain(owned *o, domain *d, uint32_t to)
{
    uint32_t far = to > d->first ? to - d->first : d->first - to, n = far < d->n ? far : d->n;
    if (to > d->first)
        move_rows(o, to + d->n - n, d->first, n);
    else
        move_rows(o, to, d->first + d->n - n, n);
    d->first = to;
}

// Moves each domain to where the ones before it, with their newcomers, end. Domains that move up go
// first, from the last one on, and then domains that move down: so each finds space.
static void move_domains(owned *o)
{
    uint32_t n = 0, k = o->n_domains;
    for (uint32_t d = 0; d < k; ++d)
        n += o->domains[d].n + o->domains[d].n_new;
    for (uint32_t d = k, end = n; d-- > 0;) {
        domain *at = &o->domains[d];
        end -= at->n + at->n_new;
        if (end > at->first)
            move_domain(o, at, end);
    }
    for (uint32_t d = 0, first = 0; d < k; first += o->domains[d].n + o->domains[d].n_new, ++d)
        if (first < o->domains[d].first)
            move_domain(o, &o->domains[d], first);
}

static bool insert_newcomers(owned *o, duet_error *err)
{
    uint32_t first_new = o->domains[0].first_new, n = o->rows.n - first_new;
    object_rows copy = {0};
    if (!object_rows_begin(&copy, &o->form, n, err))
        return false;
    copy.n = 0;
    if (n > 0)
        object_rows_append(&copy, &o->form, o->rows.ids + first_new,
                           object_row(&o->rows, &o->form, first_new), n);
    close_gaps(o);
    move_domains(o);
    for (uint32_t i = 0, from = 0; i < o->n_domains; ++i) {
        domain *d = &o->domains[i];
        object_rows to = o->rows;
        to.n = d->first + d->n;
        object_rows_append(&to, &o->form, copy.ids + from, object_row(&copy, &o->form, from),
                           d->n_new);
        from += d->n_new;
        d->n += d->n_new;
    }
    object_rows_end(&copy);
    return true;
}

bool owned_tidy(owned *o, duet_error *err)
{
    if (o->leavers.n == 0 && o->domains[0].first_new == o->rows.n)
        return true;
    bool is_only = o->n_domains == 1 || o->placement != PLACED_BY_DOMAIN;
    if (is_only) {
        close_gaps(o);
        join_newcomers(o);
    } else if (!insert_newcomers(o, err)) {
        return false;
    }
    o->rows.n = 0;
    for (uint32_t i = 0; i < o->n_domains; ++i)
        o->rows.n += o->domains[i].n;
    for (uint32_t i = 0; i < o->n_domains; ++i) {
        o->domains[i].n_new = 0;
        o->domains[i].first_new = o->rows.n;
        if (is_only && i > 0)
            o->domains[i].first = o->rows.n;
    }
    return true;
}

// ---------------------------------------------------------------- newcomers

typedef struct writing {
    owned *o;
    const parcels *messages;
    uint32_t at;
} writing;

static void write_messages(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const writing *w = context;
    const unsigned char *from = w->messages->rows;
    object_rows to = w->o->rows;
    (void)part;
    to.n = w->at + (uint32_t)first;
    for (uint64_t i = first; i < end; ++i) {
        const unsigned char *message = from + i * w->messages->row_bytes;
        uint64_t id;
        memcpy(&id, message, sizeof id);
        object_rows_append(&to, &w->o->form, &id, message + sizeof id, 1);
    }
}

static uint32_t domain_at(const owned *o, const void *object)
{
    double centre[3];
    object_centre(&o->form, object, centre);
    return bisection_part(&o->planes, centre);
}

// Sorts the messages by their domains. False without memory.
static bool sort_messages(owned *o, parcels *messages)
{
    size_t bytes = messages->row_bytes;
    uint32_t *of = malloc((messages->n + 1) * sizeof *of), n = 0;
    unsigned char *sorted = malloc(messages->n * bytes + 1), *from = messages->rows;
    bool ok = of && sorted;
    for (uint64_t i = 0; ok && i < messages->n; ++i) {
        of[i] = domain_at(o, from + i * bytes + sizeof(uint64_t));
        ++o->domains[of[i]].n_new;
    }
    for (uint32_t d = 0; ok && d < o->n_domains; ++d) {
        o->domains[d].first_new = o->rows.n + n;
        n += o->domains[d].n_new;
        o->domains[d].n_new = 0;
    }
    for (uint64_t i = 0; ok && i < messages->n; ++i) {
        domain *d = &o->domains[of[i]];
        uint64_t to = d->first_new - o->rows.n + d->n_new++;
        memcpy(sorted + to * bytes, from + i * bytes, bytes);
    }
    if (ok)
        memcpy(from, sorted, messages->n * bytes);
    free(sorted);
    free(of);
    return ok;
}

bool owned_add_newcomers(owned *o, const parcels *messages, duet_error *err)
{
    bool sorts = o->n_domains > 1 && o->placement == PLACED_BY_DOMAIN;
    parcels in_order = *messages;
    if (!owned_reserve(o, messages->n, err) ||
        (sorts && !sort_messages(o, &in_order) && !no_memory(messages->n, err)))
        return false;
    if (!sorts)
        o->domains[0].n_new = (uint32_t)messages->n;
    for (uint32_t d = 1; !sorts && d < o->n_domains; ++d)
        o->domains[d].first_new = o->rows.n + (uint32_t)messages->n;
    writing w = {o, &in_order, o->rows.n};
    parallel_each(o->threads, messages->n, write_messages, &w);
    o->rows.n += (uint32_t)messages->n;
    return true;
}

void owned_drop_newcomers(owned *o, uint32_t first)
{
    o->rows.n = first;
    for (uint32_t d = 0; d < o->n_domains; ++d) {
        o->domains[d].first_new = first;
        o->domains[d].n_new = 0;
    }
}

// ---------------------------------------------------------------- domains

bool owned_is_uneven(const owned *o)
{
    uint32_t most = 0, n = owned_count(o);
    for (uint32_t d = 0; d < o->n_domains; ++d)
        most = o->domains[d].n > most ? o->domains[d].n : most;
    double unevenness = n > 0 ? (double)most * o->n_domains / n : 1;
    return unevenness > 1.2 * o->unevenness;
}

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
    move_rows(o, a, b, 1);
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
static bool sort_rows(owned *o, duet_error *err)
{
    uint32_t n = 1;
    span *spans = malloc(8 * (size_t)o->n_domains * sizeof *spans);
    if (!spans)
        return no_memory(o->rows.n, err);
    span *now = spans, *next = spans + 4 * (size_t)o->n_domains;
    now[0] = (span){0, o->n_domains, 0, o->rows.n};
    for (; n < o->n_domains; n *= 2) {
        for (uint32_t from = 0; from < n; from += PARALLEL_MOST) {
            sorting s = {o, now + from, next + 2 * (size_t)from};
            parallel_jobs(o->threads, n - from < PARALLEL_MOST ? n - from : PARALLEL_MOST, halve,
                          &s);
        }
        span *before = now;
        now = next;
        next = before;
    }
    for (uint32_t i = 0; i < n; ++i)
        if (now[i].first < now[i].end) {
            domain *d = &o->domains[now[i].first];
            d->first = now[i].row;
            d->n = now[i].end_row - now[i].row;
        }
    free(spans);
    return true;
}

static void set_boxes(owned *o, const extent *box)
{
    for (uint32_t d = 0; d < o->n_domains; ++d) {
        extent *own = &o->domains[d].box;
        bisection_box(&o->planes, d, own->lower, own->upper);
        for (int k = 0; k < 3; ++k) {
            own->lower[k] = fmax(own->lower[k], box->lower[k]);
            own->upper[k] = fmin(own->upper[k], box->upper[k]);
        }
    }
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

static bool order_domain(owned *o, const domain *d, worker *w, duet_error *err)
{
    reordering r = {.o = o, .first = d->first};
    if (d->n == 0)
        return true;
    r.copy.ids = malloc(d->n * sizeof *r.copy.ids);
    r.order = malloc(d->n * sizeof *r.order);
    r.scratch = malloc((size_t)d->n * WORKER_ORDER_SCRATCH);
    bool ok = (r.copy.ids && r.order && r.scratch) || no_memory(d->n, err);
    r.copy.objects = ok ? w->map(w, d->n, err) : NULL;
    ok = ok && r.copy.objects;
    if (ok) {
        parallel_copy(o->threads, r.copy.ids, o->rows.ids + d->first, d->n, sizeof *r.copy.ids);
        parallel_copy(o->threads, r.copy.objects, object_row(&o->rows, &o->form, d->first), d->n,
                      o->form.bytes);
        ok = w->order(w, o->threads->n, r.order, r.scratch, err);
    }
    if (ok)
        parallel_each(o->threads, d->n, put_in_order, &r);
    free(r.scratch);
    free(r.order);
    free(r.copy.ids);
    return ok;
}

// Moves the rows to the worker's memory, the last ones first, and gives back the memory they leave.
static bool move_in(owned *o, worker *w, duet_error *err)
{
    unsigned char *objects = w->extend(w, o->rows.n, 0, err);
    if (!objects)
        return false;
    for (uint32_t first, end = o->rows.n; end > 0; end = first) {
        first = end > ROWS_AT_ONCE ? end - ROWS_AT_ONCE : 0;
        size_t before = (size_t)first * o->form.bytes;
        parallel_copy(o->threads, objects + before, o->rows.objects + before, end - first,
                      o->form.bytes);
        void *rest = realloc(o->rows.objects, before + 1);
        o->rows.objects = rest ? rest : o->rows.objects;
    }
    free(o->rows.objects);
    o->rows.objects = objects;
    o->holder = w;
    o->renamed.failed = true;
    return true;
}

bool owned_place(owned *o, const extent *box, worker *const workers[2], duet_error *err)
{
    bool ok = true;
    o->placement = PLACED_BY_RANK;
    owned_forget_domains(o);
    o->domains[0].box = *box;
    if (o->n_domains > 1) {
        ok = make_planes(o, err) && sort_rows(o, err);
        set_boxes(o, box);
    }
    for (uint32_t d = 0; ok && !o->holder && d < o->n_domains; ++d) {
        worker *w = workers[d % 2];
        ok = w->use_grid(w, d, err) && order_domain(o, &o->domains[d], w, err);
    }
    if (ok && o->n_domains == 1 && !o->holder)
        ok = move_in(o, workers[0], err);
    if (!ok) {
        owned_forget_domains(o);
        o->domains[0].box = *box;
        return false;
    }
    o->placement = PLACED_BY_DOMAIN;
    ++o->n_placed;
    o->unevenness = 1;
    if (o->n_domains > 1 && owned_count(o) > 0) {
        uint32_t most = 0;
        for (uint32_t d = 0; d < o->n_domains; ++d)
            most = o->domains[d].n > most ? o->domains[d].n : most;
        o->unevenness = fmax(1, (double)most * o->n_domains / owned_count(o));
    }
    return true;
}
