// SPDX-License-Identifier: MIT
#include "cluster/arrange.h"

#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static int by_row(const void *left, const void *right)
{
    const stray *p = left, *q = right;
    return (p->row > q->row) - (p->row < q->row);
}

// Rows [first, end).
typedef struct span {
    uint32_t first, end;
} span;

// A range before and after, and of both the rows that it keeps, unless they are strays.
typedef struct change {
    span before, after, kept;
    uint64_t n_taken; // rows that come to it, and then where the next of them goes in the list
} change;

typedef struct arranging {
    object_rows *rows;
    const object_form *form;
    const stray *strays; // [n] by ascending row
    uint64_t n;
    change *changes; // [n_ranges]
    uint32_t n_ranges;
    stray *taken; // [n_taken] all that move, and their ranges
    uint64_t n_taken;
} arranging;

static uint64_t first_stray(const arranging *a, uint32_t row)
{
    uint64_t first = 0, end = a->n;
    while (first < end) {
        uint64_t middle = first + (end - first) / 2;
        if (a->strays[middle].row < row)
            first = middle + 1;
        else
            end = middle;
    }
    return first;
}

// What each range has before and after. Returns how many rows move at most.
static uint64_t find_changes(arranging *a, const uint32_t *ends)
{
    uint64_t most = a->n;
    uint32_t from = 0, to = 0;
    for (uint32_t i = 0; i < a->n_ranges; ++i) {
        change *c = &a->changes[i];
        *c = (change){.before = {from, i + 1 < a->n_ranges ? ends[i] : a->rows->n}};
        from = c->before.end;
        c->n_taken = from - c->before.first;
    }
    for (uint64_t k = 0, i = 0; k < a->n; ++k) {
        while (a->strays[k].row >= a->changes[i].before.end)
            ++i;
        --a->changes[i].n_taken;
        ++a->changes[a->strays[k].to].n_taken;
    }
    for (uint32_t i = 0; i < a->n_ranges; ++i) {
        change *c = &a->changes[i];
        const span *b = &c->before;
        c->after = (span){to, to + (uint32_t)c->n_taken};
        to = c->after.end;
        uint32_t first = b->first > c->after.first ? b->first : c->after.first;
        uint32_t end = b->end < c->after.end ? b->end : c->after.end;
        c->kept = first < end ? (span){first, end} : (span){b->end, b->end};
        c->n_taken = 0;
        most += (b->end - b->first) - (c->kept.end - c->kept.first);
    }
    return most;
}

// Those of a range's rows that are no strays and that it does not keep where they are.
static void take_rows(arranging *a, uint32_t range, uint32_t first, uint32_t end)
{
    uint64_t k = first_stray(a, first);
    for (uint32_t row = first; row < end; ++row) {
        if (k < a->n && a->strays[k].row == row)
            ++k;
        else
            a->taken[a->n_taken++] = (stray){row, range};
    }
}

static void take_all(arranging *a)
{
    memcpy(a->taken, a->strays, a->n * sizeof *a->taken);
    a->n_taken = a->n;
    for (uint32_t i = 0; i < a->n_ranges; ++i) {
        const change *c = &a->changes[i];
        take_rows(a, i, c->before.first, c->kept.first);
        take_rows(a, i, c->kept.end, c->before.end);
    }
}

// What was taken, range after range.
static void copy_taken(arranging *a, object_rows *copy)
{
    uint64_t all = 0;
    for (uint64_t k = 0; k < a->n_taken; ++k)
        ++a->changes[a->taken[k].to].n_taken;
    for (uint32_t i = 0; i < a->n_ranges; ++i) {
        uint64_t n = a->changes[i].n_taken;
        a->changes[i].n_taken = all;
        all += n;
    }
    for (uint64_t k = 0; k < a->n_taken; ++k) {
        uint32_t row = a->taken[k].row, at = (uint32_t)a->changes[a->taken[k].to].n_taken++;
        copy->ids[at] = a->rows->ids[row];
        memcpy(object_row(copy, a->form, at), object_row(a->rows, a->form, row), a->form->bytes);
    }
}

static void put_row(const arranging *a, uint32_t row, const object_rows *copy, uint32_t from)
{
    a->rows->ids[row] = copy->ids[from];
    memcpy(object_row(a->rows, a->form, row), object_row(copy, a->form, from), a->form->bytes);
}

// Into the places of a range that it does not keep, and where its strays lay.
static void put_all(const arranging *a, const object_rows *copy)
{
    uint32_t from = 0;
    for (uint32_t i = 0; i < a->n_ranges; ++i) {
        const change *c = &a->changes[i];
        bool keeps = c->kept.first < c->kept.end;
        uint32_t first = keeps ? c->kept.first : c->after.end;
        for (uint32_t row = c->after.first; row < first; ++row)
            put_row(a, row, copy, from++);
        for (uint64_t k = first_stray(a, c->kept.first);
             keeps && k < a->n && a->strays[k].row < c->kept.end; ++k)
            put_row(a, a->strays[k].row, copy, from++);
        for (uint32_t row = c->kept.end; keeps && row < c->after.end; ++row)
            put_row(a, row, copy, from++);
    }
}

bool rows_arrange(object_rows *rows, const object_form *form, uint32_t *ends, uint32_t n_ranges,
                  stray *strays, uint64_t n, duet_error *err)
{
    arranging a = {.rows = rows, .form = form, .strays = strays, .n = n, .n_ranges = n_ranges};
    object_rows copy = {0};
    if (n == 0)
        return true;
    qsort(strays, n, sizeof *strays, by_row);
    a.changes = malloc(n_ranges * sizeof *a.changes);
    uint64_t most = a.changes ? find_changes(&a, ends) : 0;
    a.taken = malloc((most + 1) * sizeof *a.taken);
    bool ok = a.changes && a.taken && object_rows_begin(&copy, form, most, NULL);
    if (ok) {
        take_all(&a);
        copy_taken(&a, &copy);
        put_all(&a, &copy);
        for (uint32_t i = 0; i + 1 < n_ranges; ++i)
            ends[i] = a.changes[i].after.end;
    }
    object_rows_end(&copy);
    free(a.taken);
    free(a.changes);
    return ok || error_set(err, DUET_STATUS_NO_MEMORY,
                           "%" PRIu64 " objects that change parts: no memory", most);
}

// ---------------------------------------------------------------- all rows

enum { MOST_ROW_BYTES = 64 };

_Static_assert(sizeof(duet_large_pose) <= MOST_ROW_BYTES, "the largest row");

void rows_exchange(object_rows *rows, const object_form *form, uint32_t a, uint32_t b)
{
    unsigned char object[MOST_ROW_BYTES];
    uint64_t id = rows->ids[a];
    rows->ids[a] = rows->ids[b];
    rows->ids[b] = id;
    memcpy(object, object_row(rows, form, a), form->bytes);
    memcpy(object_row(rows, form, a), object_row(rows, form, b), form->bytes);
    memcpy(object_row(rows, form, b), object, form->bytes);
}

// A piece of a span, which one thread halves: rows from `middle` on belong to the span's upper
// half.
typedef struct piece {
    uint32_t first, middle, end;
} piece;

// A span of ranges, which rows are in by now, and its halves. Spans are alike but for one range.
typedef struct halving {
    uint32_t first, middle, end; // ranges
    uint32_t first_row, end_row;
} halving;

typedef struct sorting {
    object_rows *rows;
    const object_form *form;
    uint32_t n_ranges;
    uint32_t *ends;
    row_range *range_of;
    const void *context;
    uint32_t n_spans;
    uint32_t from;     // of these, that are halved at once
    uint32_t n_pieces; // of each of them
    piece pieces[PARALLEL_MOST];
    const piece *joined; // those of the span whose pieces are brought together,
    uint32_t middle;     // the first row of its upper half,
    uint32_t n_wrong;    // and the rows before it that belong behind it, as many as the reverse
} sorting;

static halving halving_at(const sorting *s, uint64_t at)
{
    halving x = {.first = (uint32_t)(s->n_ranges * at / s->n_spans),
                 .middle = (uint32_t)(s->n_ranges * (2 * at + 1) / (2 * s->n_spans)),
                 .end = (uint32_t)(s->n_ranges * (at + 1) / s->n_spans)};
    x.first_row = x.first > 0 ? s->ends[x.first - 1] : 0;
    x.end_row = x.end > 0 ? s->ends[x.end - 1] : 0;
    return x;
}

static bool has_halves(const halving *x)
{
    return x->first < x->middle && x->middle < x->end;
}

static bool is_below(const sorting *s, uint32_t row, uint32_t range)
{
    return s->range_of(s->context, object_row(s->rows, s->form, row)) < range;
}

// Rows of a piece are read and written from both ends on.
static void halve(void *context, uint32_t job, uint64_t unused_first, uint64_t unused_end)
{
    sorting *s = context;
    halving x = halving_at(s, s->from + job / s->n_pieces);
    piece *p = &s->pieces[job];
    uint64_t n = x.end_row - x.first_row, k = job % s->n_pieces;
    (void)unused_first, (void)unused_end;
    if (!has_halves(&x))
        return;
    p->first = x.first_row + (uint32_t)(n * k / s->n_pieces);
    p->end = x.first_row + (uint32_t)(n * (k + 1) / s->n_pieces);
    uint32_t i = p->first, j = p->end;
    for (;;) {
        while (i < j && is_below(s, i, x.middle))
            ++i;
        while (i < j && !is_below(s, j - 1, x.middle))
            --j;
        if (i == j)
            break;
        rows_exchange(s->rows, s->form, i++, --j);
    }
    p->middle = i;
}

// Rows of one half that lie where the other one belongs, piece after piece.
typedef struct wrong_rows {
    bool are_below;
    const piece *next;
    uint32_t row, end; // in the piece before that
} wrong_rows;

static void turn_to_next_piece(const sorting *s, wrong_rows *w)
{
    const piece *p = w->next++;
    w->row = p->middle;
    w->end = p->end < s->middle ? p->end : s->middle;
    if (w->are_below) {
        w->row = p->first > s->middle ? p->first : s->middle;
        w->end = p->middle;
    }
    w->end = w->end > w->row ? w->end : w->row;
}

static wrong_rows wrong_rows_from(const sorting *s, bool are_below, uint32_t n)
{
    wrong_rows w = {.are_below = are_below, .next = s->joined};
    while (n >= w.end - w.row) {
        n -= w.end - w.row;
        turn_to_next_piece(s, &w);
    }
    w.row += n;
    return w;
}

static uint32_t next_wrong_row(const sorting *s, wrong_rows *w)
{
    while (w->row == w->end)
        turn_to_next_piece(s, w);
    return w->row++;
}

static void exchange_wrong(void *context, uint32_t job, uint64_t unused_first, uint64_t unused_end)
{
    const sorting *s = context;
    uint64_t n = s->n_wrong;
    uint32_t i = (uint32_t)(n * job / s->n_pieces), end = (uint32_t)(n * (job + 1) / s->n_pieces);
    (void)unused_first, (void)unused_end;
    if (i == end)
        return;
    wrong_rows above = wrong_rows_from(s, false, i), below = wrong_rows_from(s, true, i);
    for (; i < end; ++i)
        rows_exchange(s->rows, s->form, next_wrong_row(s, &above), next_wrong_row(s, &below));
}

// The pieces are halved, and the span comes to be.
static void join_pieces(sorting *s, const halving *x, const piece *pieces, parallel *threads)
{
    s->joined = pieces;
    s->middle = x->first_row;
    s->n_wrong = 0;
    for (uint32_t k = 0; k < s->n_pieces; ++k)
        s->middle += pieces[k].middle - pieces[k].first;
    for (wrong_rows w = {.are_below = true, .next = pieces}; w.next < pieces + s->n_pieces;) {
        turn_to_next_piece(s, &w);
        s->n_wrong += w.end - w.row;
    }
    parallel_jobs(threads, s->n_pieces, exchange_wrong, s);
    s->ends[x->middle - 1] = s->middle;
}

// By all threads, also where there are fewer spans.
static void halve_all(sorting *s, parallel *threads)
{
    s->n_pieces = s->n_spans < threads->n ? threads->n / s->n_spans : 1;
    uint32_t at_once = PARALLEL_MOST / s->n_pieces;
    for (s->from = 0; s->from < s->n_spans; s->from += at_once) {
        uint32_t left = s->n_spans - s->from, n = left < at_once ? left : at_once;
        parallel_jobs(threads, n * s->n_pieces, halve, s);
        for (uint32_t i = 0; i < n; ++i) {
            halving x = halving_at(s, s->from + i);
            if (has_halves(&x))
                join_pieces(s, &x, &s->pieces[i * s->n_pieces], threads);
        }
    }
}

// In memory from one end to the other: to exchange rows that lie anywhere takes four times as long.
void rows_sort(object_rows *rows, const object_form *form, uint32_t n, uint32_t *ends,
               uint32_t n_ranges, row_range *range_of, const void *context, parallel *threads)
{
    sorting s = {.rows = rows,
                 .form = form,
                 .n_ranges = n_ranges,
                 .ends = ends,
                 .range_of = range_of,
                 .context = context};
    ends[n_ranges - 1] = n;
    for (s.n_spans = 1; s.n_spans < n_ranges; s.n_spans *= 2)
        halve_all(&s, threads);
}
