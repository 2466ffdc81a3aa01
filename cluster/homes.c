// SPDX-License-Identifier: MIT
#include "cluster/homes.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void homes_take(homes *h, object_rows *rows)
{
    object_rows_end(&h->rows);
    h->rows = *rows;
    h->widest = 0;
    h->is_cut = false;
    *rows = (object_rows){0};
}

void homes_end(homes *h)
{
    object_rows_end(&h->rows);
    object_rows_end(&h->spare);
    free(h->all);
    h->all = NULL;
}

// ---------------------------------------------------------------- a look at all

// What one thread sees.
typedef struct glance {
    uint64_t bad;
    uint64_t first_bad; // its id
    double widest;
    level_boxes boxes; // each of its level alone
    uint32_t *leavers; // ascending
    uint64_t n_leavers;
    uint64_t capacity;
    bool failed; // no memory
} glance;

typedef struct look {
    const homes *h;
    const cut *c;
    glance *parts; // [PARALLEL_MOST]
    glance all;    // without leavers
} look;

static void forget(glance *g)
{
    *g = (glance){.first_bad = UINT64_MAX};
    for (int l = 0; l < LEVELS; ++l)
        g->boxes.upto[l] = reach_none;
}

static void note_leaver(glance *g, uint32_t i)
{
    if (g->failed || g->n_leavers == g->capacity) {
        uint64_t capacity = g->capacity ? 2 * g->capacity : 256;
        uint32_t *leavers = realloc(g->leavers, capacity * sizeof *leavers);
        g->failed = !leavers;
        if (!leavers) {
            ++g->n_leavers; // so that all ranks know that there is one
            return;
        }
        g->leavers = leavers;
        g->capacity = capacity;
    }
    g->leavers[g->n_leavers++] = i;
}

static void look_at_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    look *l = context;
    const homes *h = l->h;
    glance *g = &l->parts[part];
    for (uint32_t i = (uint32_t)first; i < end; ++i) {
        const void *object = object_row(&h->rows, &h->form, i);
        if (!object_is_sound(&h->form, object)) {
            g->first_bad = g->bad == 0 ? h->rows.ids[i] : g->first_bad;
            ++g->bad;
            continue;
        }
        reach e = reach_of(&h->form, object);
        double width = reach_widest(&e);
        g->widest = fmax(g->widest, width);
        reach_add(&g->boxes.upto[level_of(width, h->widest)], &e);
        double centre[3];
        object_centre(&h->form, object, centre);
        if (h->is_cut && !cut_keeps(l->c, centre))
            note_leaver(g, i);
    }
}

static void look_again(look *l)
{
    for (int i = 0; i < PARALLEL_MOST; ++i) {
        free(l->parts[i].leavers);
        forget(&l->parts[i]);
    }
    uint32_t n = parallel_each(l->h->threads, l->h->rows.n, look_at_part, l);
    forget(&l->all);
    for (uint32_t i = 0; i < n; ++i) {
        const glance *g = &l->parts[i];
        l->all.bad += g->bad;
        l->all.first_bad = l->all.first_bad < g->first_bad ? l->all.first_bad : g->first_bad;
        l->all.widest = fmax(l->all.widest, g->widest);
        l->all.n_leavers += g->n_leavers;
        l->all.failed |= g->failed;
        for (int k = 0; k < LEVELS; ++k)
            reach_add(&l->all.boxes.upto[k], &g->boxes.upto[k]);
    }
}

static void end_look(look *l)
{
    for (int i = 0; l->parts && i < PARALLEL_MOST; ++i)
        free(l->parts[i].leavers);
    free(l->parts);
}

// What all ranks' looks say.
typedef struct overview {
    uint64_t objects, bad, leavers;
    double widest;
    double unevenness; // the most objects that a rank has for those that its weight makes due to it
} overview;

static bool look_over(overview *o, const look *l, bool ok, ranks *r, duet_error *err)
{
    tally t = {.sums = {l->h->rows.n, l->all.bad, l->all.n_leavers},
               .greatest = {l->all.widest, l->h->rows.n / l->c->due}};
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

static bool find_leavers(leavers *out, const look *l, uint64_t *counts, duet_error *err)
{
    uint64_t most = l->all.n_leavers + 1;
    out->list = malloc(most * sizeof *out->list);
    out->destinations = malloc(most * sizeof *out->destinations);
    if (!out->list || !out->destinations || l->all.failed)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects that leave: no memory",
                         most);
    for (int part = 0; part < PARALLEL_MOST; ++part) {
        const glance *g = &l->parts[part];
        for (uint64_t k = 0; k < g->n_leavers; ++k) {
            double centre[3];
            uint32_t i = g->leavers[k];
            object_centre(&l->h->form, object_row(&l->h->rows, &l->h->form, i), centre);
            int to = cut_home(l->c, centre);
            out->list[out->n] = i;
            out->destinations[out->n++] = to;
            ++counts[to];
        }
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

static void add_arrivals(homes *h, const arrival *arrivals, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i) {
        reach e = reach_of(&h->form, arrivals[i].object);
        reach_add(&h->boxes.upto[level_of(reach_widest(&e), h->widest)], &e);
    }
}

// The homes that leave are let go of once all ranks have taken what came to them.
static bool take_arrivals(homes *h, ranks *r, const leavers *l, const parcels *in, duet_error *err)
{
    arrival *arrivals = arrivals_read(&h->form, in->rows, in->n, err);
    bool ok = arrivals && object_rows_reserve(&h->spare, &h->form, h->rows.n - l->n + in->n, err);
    ok =
        ok && object_rows_merge(&h->spare, &h->form, &h->rows, l->list, l->n, arrivals, in->n, err);
    ok = ranks_agree(r, ok, err);
    if (ok) {
        object_rows before = h->rows;
        add_arrivals(h, arrivals, in->n);
        h->rows = h->spare;
        h->spare = before;
    }
    free(arrivals);
    return ok;
}

static bool move_leavers(const look *seen, homes *h, ranks *r, duet_error *err)
{
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    leavers l = {0};
    parcels out = {0}, in = {0};
    bool ok = parcels_begin(&out, r, object_message_bytes(&h->form), err);
    if (ok && !places)
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    ok = ok && find_leavers(&l, seen, out.counts, err) && parcels_reserve(&out, r, places, err);
    if (ok)
        write_leavers(h, &l, places, &out);
    ok = ranks_exchange(r, ok, &out, &in, err);
    ok = ok && take_arrivals(h, r, &l, &in, err);
    parcels_end(&in);
    parcels_end(&out);
    free(places);
    free(l.list);
    free(l.destinations);
    return ok;
}

// ---------------------------------------------------------------- settling

// Levels are those of the widest object there was: until one is wider, or they are too fine by
// far. The same on all ranks.
static bool keep_widest(homes *h, double widest)
{
    if (widest <= h->widest && h->widest <= 4 * widest)
        return true;
    h->widest = widest;
    return false;
}

void level_boxes_join(level_boxes *boxes)
{
    for (int k = 1; k < LEVELS; ++k)
        reach_add(&boxes->upto[k], &boxes->upto[k - 1]);
}

// Whose level changed is looked at again, and who leaves goes. Where any did, o is of before.
static bool move(look *l, overview *o, homes *h, ranks *r, duet_error *err)
{
    if (!keep_widest(h, o->widest))
        look_again(l);
    h->boxes = l->all.boxes;
    return o->leavers == 0 || move_leavers(l, h, r, err);
}

// A look tells who leaves. What has arrived where a new cut has it is looked at again, and whoever
// has too much makes for a new cut.
static bool settle(look *l, bool ok, homes *h, ranks *r, cut *c, double imbalance, duet_error *err)
{
    overview o;
    if (ok)
        look_again(l);
    if (!look_over(&o, l, ok, r, err))
        return false;
    if (o.bad > 0)
        return refuse_bad(l, &o, r, err);
    if (h->is_cut) {
        if (!move(l, &o, h, r, err) || (o.leavers > 0 && !look_over(&o, l, true, r, err)))
            return false;
        if (o.unevenness <= imbalance * h->unevenness)
            return true;
    }
    h->is_cut = false;
    if (!cut_make(c, r, &h->form, &h->rows, err))
        return false;
    h->is_cut = true;
    ++h->n_cuts;
    look_again(l);
    if (!look_over(&o, l, true, r, err) || !move(l, &o, h, r, err))
        return false;
    look_again(l);
    h->boxes = l->all.boxes;
    if (!look_over(&o, l, true, r, err))
        return false;
    h->unevenness = o.unevenness;
    return true;
}

bool homes_settle(homes *h, ranks *r, cut *c, double imbalance, duet_error *err)
{
    look l = {.h = h, .c = c, .parts = calloc(PARALLEL_MOST, sizeof *l.parts)};
    bool ok = l.parts || error_set(err, DUET_STATUS_NO_MEMORY, "a look at the homes: no memory");
    if (!h->all)
        h->all = malloc((size_t)r->n * sizeof *h->all);
    if (ok && !h->all)
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "boxes of %d ranks: no memory", r->n);
    ok = settle(&l, ok, h, r, c, imbalance, err);
    if (ok)
        level_boxes_join(&h->boxes);
    end_look(&l);
    return ok;
}
