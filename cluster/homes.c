// SPDX-License-Identifier: MIT
#include "cluster/homes.h"

#include "base/compare.h"
#include "base/error.h"
#include "cluster/arrange.h"
#include "cluster/look.h"
#include "cluster/owner.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- rows

static void unlock_ids(homes *h)
{
    if (h->ids_locked)
        h->holder->lock(h->holder, NULL, 0);
    h->ids_locked = false;
}

void homes_lock_ids(homes *h)
{
    if (h->ids_locked || !h->holder->lock)
        return;
    h->holder->lock(h->holder, h->rows.ids, h->rows.capacity * sizeof *h->rows.ids);
    h->ids_locked = true;
}

// What a worker holds is its own.
static void let_go(homes *h)
{
    unlock_ids(h);
    if (h->holder)
        h->rows.objects = NULL;
    object_rows_end(&h->rows);
    free(h->gone);
    free(h->gone_to);
    h->gone = NULL;
    h->gone_to = NULL;
    h->holder = NULL;
    h->ranges = NULL;
    h->n_ranges = h->n_gone = 0;
}

void homes_take(homes *h, object_rows *rows)
{
    let_go(h);
    object_rows_end(&h->spare); // its rows may be of another size
    h->rows = *rows;
    h->widest = 0;
    h->is_cut = false;
    *rows = (object_rows){0};
}

void homes_end(homes *h)
{
    let_go(h);
    object_rows_end(&h->spare);
    for (int i = 0; h->glances && i < PARALLEL_MOST; ++i) {
        free(h->glances[i].leavers.rows);
        free(h->glances[i].border.rows);
        free(h->glances[i].edges.rows);
        free(h->glances[i].outside.rows);
    }
    free(h->glances);
    free(h->all);
    free(h->arrived);
    free(h->border.rows);
    free(h->edges.rows);
    free(h->outside.rows);
    free(h->renamed.rows);
    h->all = NULL;
    h->arrived = NULL;
    h->glances = NULL;
    h->border = h->edges = h->outside = h->renamed = (row_list){0};
}

void homes_tidy(homes *h)
{
    while (h->n_gone > 0) {
        uint32_t hole = h->gone[--h->n_gone], last = --h->rows.n;
        if (hole == last)
            continue;
        h->rows.ids[hole] = h->rows.ids[last];
        memcpy(object_row(&h->rows, &h->form, hole), object_row(&h->rows, &h->form, last),
               h->form.bytes);
        row_list_add(&h->renamed, hole);
    }
}

// From the last one on, so that none takes the place of another one.
void homes_move_gone_last(homes *h)
{
    for (uint32_t k = h->n_gone, to = h->rows.n; k-- > 0;) {
        rows_exchange(&h->rows, &h->form, h->gone[k], --to);
        h->gone[k] = to;
    }
}

void homes_forget_renamed(homes *h)
{
    h->renamed = (row_list){.rows = h->renamed.rows, .capacity = h->renamed.capacity};
    h->all_renamed = false;
}

uint32_t homes_open(homes *h)
{
    homes_tidy(h);
    if (h->holder)
        h->rows.objects = h->holder->map(h->holder, h->rows.n, NULL);
    return h->rows.n;
}

enum { ROWS_AT_ONCE = 1 << 20 };

// The last rows come first, and the memory that they leave is given back.
bool homes_move_in(homes *h, worker *w, duet_error *err)
{
    unsigned char *objects = w->extend(w, h->rows.n, 0, err);
    if (!objects)
        return false;
    for (uint32_t first, end = h->rows.n; end > 0; end = first) {
        first = end > ROWS_AT_ONCE ? end - ROWS_AT_ONCE : 0;
        size_t before = (size_t)first * h->form.bytes;
        parallel_copy(h->threads, objects + before, h->rows.objects + before, end - first,
                      h->form.bytes);
        void *rest = realloc(h->rows.objects, before + 1);
        h->rows.objects = rest ? rest : h->rows.objects;
    }
    free(h->rows.objects);
    object_rows_end(&h->spare);
    h->rows.objects = objects;
    h->holder = w;
    h->all_renamed = true;
    return true;
}

void reordering_end(reordering *o)
{
    object_rows_end(&o->copy);
    free(o->order);
    *o = (reordering){0};
}

static bool reserve_order(reordering *o, const object_form *form, uint32_t n, duet_error *err)
{
    uint64_t capacity = o->copy.capacity;
    if (!object_rows_reserve(&o->copy, form, n, err))
        return false;
    if (o->copy.capacity != capacity) {
        free(o->order);
        o->order = malloc((o->copy.capacity + 1) * sizeof *o->order);
    }
    return o->order || error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " objects: no memory", n);
}

typedef struct gathering {
    const homes *h;
    reordering *to;
    object_rows from; // the first of the range and those behind it
} gathering;

static void gather_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    gathering *g = context;
    (void)part;
    object_rows_gather(&g->to->copy, &g->h->form, first, &g->from, g->to->order + first,
                       end - first);
}

// The memory for the copies is the order's before.
bool homes_put_in_order(homes *h, uint32_t first, uint32_t n, worker *w, reordering *o,
                        duet_error *err)
{
    if (n == 0 || !w->order)
        return true;
    if (!reserve_order(o, &h->form, n, err) ||
        !w->order(w, h->threads->n, o->order, o->copy.objects, err))
        return false;
    gathering g = {h, o, {.ids = h->rows.ids + first}};
    g.from.objects = object_row(&h->rows, &h->form, first);
    parallel_each(h->threads, n, gather_part, &g);
    parallel_copy(h->threads, h->rows.ids + first, o->copy.ids, n, sizeof *o->copy.ids);
    parallel_copy(h->threads, object_row(&h->rows, &h->form, first), o->copy.objects, n,
                  h->form.bytes);
    return true;
}

bool homes_move_out(homes *h, duet_error *err)
{
    object_rows own = {0};
    homes_tidy(h);
    if (!object_rows_copy(&own, &h->form, h->rows.ids, h->rows.objects, h->rows.n, err))
        return false;
    let_go(h);
    h->rows = own;
    return true;
}

// Space for n rows in the holder's memory, which keeps those that there are.
static bool extend(homes *h, uint64_t n, duet_error *err)
{
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%" PRIu64 " objects and ghosts on one rank; expected more ranks", n);
    if (!h->rows.ids || n > h->rows.capacity) {
        uint64_t capacity = n + n / 16;
        unlock_ids(h);
        uint64_t *ids = realloc(h->rows.ids, (capacity + 1) * sizeof *ids);
        if (!ids)
            return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
        h->rows.ids = ids;
        h->rows.capacity = capacity;
    }
    void *objects = h->holder->extend(h->holder, (uint32_t)n, h->rows.n, err);
    if (objects)
        h->rows.objects = objects;
    return objects;
}

bool homes_reserve_behind(homes *h, uint64_t n, duet_error *err)
{
    return extend(h, h->rows.n + n, err);
}

typedef struct writing {
    object_rows *rows;
    const object_form *form;
    uint64_t at;
    const parcels *messages;
} writing;

static void write_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const writing *w = context;
    const unsigned char *message =
        (const unsigned char *)w->messages->rows + first * w->messages->row_bytes;
    (void)part;
    for (uint64_t row = w->at + first; row < w->at + end;
         ++row, message += w->messages->row_bytes) {
        memcpy(&w->rows->ids[row], message, sizeof *w->rows->ids);
        memcpy(object_row(w->rows, w->form, (uint32_t)row), message + sizeof *w->rows->ids,
               w->form->bytes);
    }
}

void homes_write_messages(const homes *h, object_rows *rows, uint64_t at, const parcels *messages)
{
    writing w = {rows, &h->form, at, messages};
    parallel_each(h->threads, messages->n, write_part, &w);
}

bool homes_write_behind(homes *h, const parcels *messages, duet_error *err)
{
    if (!extend(h, (uint64_t)h->rows.n + messages->n, err))
        return false;
    homes_write_messages(h, &h->rows, h->rows.n, messages);
    return true;
}

// ---------------------------------------------------------------- all ranks

// What all ranks' looks say.
typedef struct overview {
    uint64_t objects, bad, leavers;
    double widest;
    double unevenness; // the most objects that a rank has for those that its weight makes due to it
} overview;

static bool look_over(overview *o, const look *l, bool ok, ranks *r, duet_error *err)
{
    uint32_t n = homes_count(l->h);
    tally t = {.sums = {n, l->all.bad, l->all.leavers.n},
               .greatest = {l->all.widest, n / l->c->due}};
    if (!ranks_agree_and(r, ok, &t, err))
        return false;
    *o = (overview){t.sums[0], t.sums[1], t.sums[2], t.greatest[0], 1};
    if (o->objects > 0)
        o->unevenness = fmax(t.greatest[1] / (double)o->objects, 1);
    return true;
}

// The line is the same on all ranks, whichever holds the object.
static bool refuse_bad(const look *l, const overview *o, ranks *r, duet_error *err)
{
    uint64_t first = l->all.first_bad;
    ranks_least(r, &first, 1);
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %" PRIu64 " of %" PRIu64 " is not a number, infinite, negative or "
                     "without rotation (%" PRIu64 " such objects)",
                     first, o->objects, o->bad);
}

// ---------------------------------------------------------------- leavers

// Leavers with where each belongs.
typedef struct leavers {
    uint32_t *list;
    int *destinations;
    uint64_t n;
} leavers;

static void list_leavers(leavers *out, const look *l)
{
    for (int part = 0; part < PARALLEL_MOST; ++part) {
        const row_list *rows = &l->parts[part].leavers;
        for (uint64_t k = 0; k < rows->n; ++k)
            out->list[out->n++] = rows->rows[k];
    }
    if (l->blocks)
        qsort(out->list, out->n, sizeof *out->list, compare_uint32);
}

static bool find_leavers(leavers *out, const look *l, uint64_t *counts, duet_error *err)
{
    uint64_t most = l->all.leavers.n + 1;
    out->list = malloc(most * sizeof *out->list);
    out->destinations = malloc(most * sizeof *out->destinations);
    if (!out->list || !out->destinations || l->all.leavers.failed)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects that leave: no memory",
                         most);
    list_leavers(out, l);
    for (uint64_t k = 0; k < out->n; ++k) {
        double centre[3];
        object_centre(&l->h->form, object_row(&l->h->rows, &l->h->form, out->list[k]), centre);
        out->destinations[k] = cut_home(l->c, centre);
        ++counts[out->destinations[k]];
    }
    return true;
}

static void write_leavers(const homes *h, const leavers *l, uint64_t *places, parcels *out)
{
    unsigned char *messages = out->rows;
    for (uint64_t k = 0; k < l->n; ++k)
        object_write_message(&h->form, messages + places[l->destinations[k]]++ * out->row_bytes,
                             h->rows.ids[l->list[k]], object_row(&h->rows, &h->form, l->list[k]));
}

// The homes that leave are let go of once all ranks have taken what came to them.
static bool merge_arrivals(homes *h, ranks *r, const leavers *l, const parcels *in, duet_error *err)
{
    arrival *arrivals = arrivals_read(&h->form, in->rows, in->n, err);
    bool ok = arrivals && object_rows_reserve(&h->spare, &h->form, h->rows.n - l->n + in->n, err);
    ok =
        ok && object_rows_merge(&h->spare, &h->form, &h->rows, l->list, l->n, arrivals, in->n, err);
    ok = ranks_agree(r, ok, err);
    if (ok) {
        object_rows before = h->rows;
        h->rows = h->spare;
        h->spare = before;
    }
    free(arrivals);
    return ok;
}

void level_boxes_add(level_boxes *boxes, const reach *e, double widest)
{
    reach_add(&boxes->upto[level_of(reach_widest(e), widest)], e);
}

// What comes is near the border, as what leaves is.
static void add_arrival(homes *h, uint32_t row)
{
    reach e = reach_of(&h->form, object_row(&h->rows, &h->form, row));
    level_boxes_add(&h->boxes, &e, h->widest);
    row_list_add(&h->border, row);
    row_list_add(&h->renamed, row);
    if (h->n_ranges > 0)
        row_list_add(&h->edges, row);
}

static void add_gone(homes *h, uint32_t row, int to)
{
    h->gone[h->n_gone] = row;
    h->gone_to[h->n_gone++] = to;
    row_list_add(&h->renamed, row);
}

// In the holder's memory.
static bool append_arrivals(homes *h, ranks *r, const leavers *l, const parcels *in,
                            duet_error *err)
{
    uint32_t *gone = realloc(h->gone, (l->n + 1) * sizeof *gone);
    int *gone_to = realloc(h->gone_to, (l->n + 1) * sizeof *gone_to);
    bool ok = (gone && gone_to) || error_set(err, DUET_STATUS_NO_MEMORY,
                                             "%" PRIu64 " objects that leave: no memory", l->n);
    h->gone = gone ? gone : h->gone;
    h->gone_to = gone_to ? gone_to : h->gone_to;
    ok = ok && homes_write_behind(h, in, err);
    if (!ranks_agree(r, ok, err))
        return false;
    for (uint64_t i = 0; i < l->n; ++i)
        add_gone(h, l->list[i], l->destinations[i]);
    h->arrived[0] = h->rows.n;
    for (int q = 0; q < r->n; ++q)
        h->arrived[q + 1] = h->arrived[q] + in->counts[q];
    for (uint64_t i = 0; i < in->n; ++i)
        add_arrival(h, h->rows.n++);
    return true;
}

static bool move_leavers(const look *seen, bool ok, homes *h, ranks *r, duet_error *err)
{
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    leavers l = {0};
    parcels out = {0}, in = {0};
    ok = parcels_begin(&out, r, object_message_bytes(&h->form), err) && ok;
    if (ok && !places)
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    ok = ok && find_leavers(&l, seen, out.counts, err) && parcels_reserve(&out, r, places, err);
    if (ok)
        write_leavers(h, &l, places, &out);
    ok = ranks_exchange(r, ok, &out, &in, err);
    ok = ok && (h->holder ? append_arrivals : merge_arrivals)(h, r, &l, &in, err);
    parcels_end(&in);
    parcels_end(&out);
    free(places);
    free(l.list);
    free(l.destinations);
    return ok;
}

// ---------------------------------------------------------------- settling

// A reach is a little wider the farther an object is from 0.
#define ROOM_TO_MOVE 1.01

// Levels are those of a little more than the widest object there was: until one is wider, or they
// are too fine by far. The same on all ranks.
static bool keep_widest(homes *h, double widest)
{
    if (widest <= h->widest && h->widest <= 4 * widest)
        return true;
    h->widest = ROOM_TO_MOVE * widest;
    return false;
}

void level_boxes_join(level_boxes *boxes)
{
    for (int k = 1; k < LEVELS; ++k)
        reach_add(&boxes->upto[k], &boxes->upto[k - 1]);
}

// All that the threads found, one behind the other.
static void keep_rows(row_list *to, const row_list *sum, const look *l, size_t list)
{
    to->n = 0;
    if (sum->n > to->capacity) {
        uint32_t *rows = realloc(to->rows, sum->n * sizeof *rows);
        to->rows = rows ? rows : to->rows;
        to->capacity = rows ? sum->n : to->capacity;
    }
    to->failed = sum->n > to->capacity || sum->failed;
    for (int i = 0; !to->failed && i < PARALLEL_MOST; ++i) {
        const row_list *of = (const row_list *)(const void *)((const char *)&l->parts[i] + list);
        if (of->n > 0)
            memcpy(to->rows + to->n, of->rows, of->n * sizeof *of->rows);
        to->n += of->n;
    }
}

// What the last look says of the homes that others may touch.
static void keep_border(homes *h, const look *l)
{
    h->boxes = l->all.boxes;
    keep_rows(&h->border, &l->all.border, l, offsetof(glance, border));
    keep_rows(&h->edges, &l->all.edges, l, offsetof(glance, edges));
    keep_rows(&h->outside, &l->all.outside, l, offsetof(glance, outside));
    h->leapt = l->all.leapt;
}

static bool has_border(const homes *h, duet_error *err)
{
    return (!h->border.failed && !h->edges.failed && !h->outside.failed) ||
           error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects at the border: no memory",
                     h->border.n + h->edges.n);
}

// Objects whose level changed are looked at again, and those that leave are sent. Then o is of the
// time before.
static bool move(look *l, overview *o, homes *h, ranks *r, duet_error *err)
{
    if (!keep_widest(h, o->widest))
        look_at_all(l);
    keep_border(h, l);
    if (o->leavers > 0 && !move_leavers(l, has_border(h, err), h, r, err))
        return false;
    if (o->leavers > 0 && !h->holder) { // rows have changed places
        look_at_all(l);
        keep_border(h, l);
    }
    return true;
}

// Of what lies in the holder's memory, too, all may leave.
static bool cut_anew(look *l, homes *h, ranks *r, cut *c, duet_error *err)
{
    overview o;
    h->is_cut = false;
    if (h->holder)
        homes_open(h);
    memset(h->arrived, 0, ((size_t)r->n + 1) * sizeof *h->arrived);
    if (!cut_make(c, r, &h->form, &h->rows, err))
        return false;
    h->is_cut = true;
    ++h->n_cuts;
    look_at_all(l);
    if (!look_over(&o, l, true, r, err) || !move(l, &o, h, r, err) ||
        !look_over(&o, l, true, r, err))
        return false;
    h->unevenness = o.unevenness;
    return true;
}

// A look tells which objects leave. If a rank then has too many, the world is cut anew. *ok is
// false if something failed on this rank alone.
static bool settle(look *l, bool *ok, homes *h, ranks *r, cut *c, double imbalance, duet_error *err)
{
    overview o;
    if (*ok)
        look_at_all(l);
    if (!look_over(&o, l, *ok, r, err))
        return false;
    if (o.bad > 0)
        return refuse_bad(l, &o, r, err);
    bool leave = o.leavers > 0;
    if (h->is_cut && (!move(l, &o, h, r, err) || (leave && !look_over(&o, l, true, r, err))))
        return false;
    if ((!h->is_cut || o.unevenness > imbalance * h->unevenness) && !cut_anew(l, h, r, c, err))
        return false;
    *ok = has_border(h, err);
    return true;
}

static reach around(const homes *h, const look *l)
{
    reach all = h->boxes.upto[LEVELS - 1];
    const reach *deep = &l->all.deep.centres;
    if (deep->lower[0] > deep->upper[0])
        return all;
    reach_add(&all, deep);
    for (int k = 0; k < 3; ++k) {
        all.lower[k] = fmin(all.lower[k], deep->lower[k] - 0.5 * h->widest);
        all.upper[k] = fmax(all.upper[k], deep->upper[k] + 0.5 * h->widest);
    }
    return all;
}

// What lies in the holder's memory may be on its way to devices while it is looked at.
static bool begin(homes *h, duet_error *err)
{
    homes_tidy(h);
    if (!h->holder)
        return true;
    void *objects = h->holder->map(h->holder, h->rows.n, err);
    if (objects) {
        h->rows.objects = objects;
        if (h->is_cut && h->n_ranges == 0)
            h->holder->begin(h->holder, h->rows.n, NULL);
    }
    return objects;
}

static bool reserve(homes *h, const ranks *r, duet_error *err)
{
    if (!h->all)
        h->all = malloc((size_t)r->n * sizeof *h->all);
    if (!h->arrived)
        h->arrived = malloc(((size_t)r->n + 1) * sizeof *h->arrived);
    if (!h->all || !h->arrived)
        return error_set(err, DUET_STATUS_NO_MEMORY, "boxes of %d ranks: no memory", r->n);
    memset(h->arrived, 0, ((size_t)r->n + 1) * sizeof *h->arrived);
    return true;
}

bool homes_settle(homes *h, ranks *r, cut *c, double imbalance, bool *settled, duet_error *err)
{
    look l = {.h = h, .c = c};
    if (!h->glances)
        h->glances = calloc(PARALLEL_MOST, sizeof *h->glances);
    if (!h->glances)
        *settled = error_set(err, DUET_STATUS_NO_MEMORY, "a look at the homes: no memory");
    l.parts = h->glances;
    *settled = *settled && reserve(h, r, err) && begin(h, err);
    bool ok = settle(&l, settled, h, r, c, imbalance, err);
    if (ok) {
        level_boxes_join(&h->boxes);
        h->around = around(h, &l);
    }
    return ok;
}

bool homes_find_edges(homes *h, const cut *c, duet_error *err)
{
    look l = {.h = h, .c = c, .parts = h->glances};
    look_at_rows(&l);
    keep_rows(&h->edges, &l.all.edges, &l, offsetof(glance, edges));
    return has_border(h, err);
}
