// SPDX-License-Identifier: MIT
#include "cluster/homes.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void forget_extents(homes *h)
{
    free(h->reaches);
    free(h->levels);
    h->reaches = NULL;
    h->levels = NULL;
}

void homes_take(homes *h, object_rows *rows)
{
    object_rows_end(&h->rows);
    forget_extents(h);
    h->rows = *rows;
    h->is_cut = false;
    *rows = (object_rows){0};
}

void homes_end(homes *h)
{
    object_rows_end(&h->rows);
    forget_extents(h);
}

// ---------------------------------------------------------------- soundness

// The line is the same on all ranks, whichever holds the object.
static bool check_objects(const homes *h, ranks *r, duet_error *err)
{
    uint64_t counts[2] = {h->rows.n, 0};
    uint64_t first = UINT64_MAX;
    for (uint32_t i = 0; i < h->rows.n; ++i) {
        if (object_is_sound(&h->form, object_row(&h->rows, &h->form, i)))
            continue;
        first = first < h->rows.ids[i] ? first : h->rows.ids[i];
        ++counts[1];
    }
    ranks_sum(r, counts, 2);
    ranks_least(r, &first, 1);
    return counts[1] == 0 ||
           error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %" PRIu64 " of %" PRIu64 " is not a number, infinite, negative or "
                     "without rotation (%" PRIu64 " such objects)",
                     first, counts[0], counts[1]);
}

// ---------------------------------------------------------------- leavers

// Where each home belongs, and how many go to each rank.
static uint64_t find_leavers(const homes *h, const ranks *r, const cut *c, int *destinations,
                             bool *stays, uint64_t *counts)
{
    uint64_t leaving = 0;
    for (uint32_t i = 0; i < h->rows.n; ++i) {
        double centre[3];
        object_centre(&h->form, object_row(&h->rows, &h->form, i), centre);
        destinations[i] = cut_home(c, centre);
        stays[i] = destinations[i] == r->self;
        leaving += !stays[i];
        counts[destinations[i]] += !stays[i];
    }
    return leaving;
}

static void write_leavers(const homes *h, const int *destinations, const bool *stays,
                          uint64_t *places, parcels *out)
{
    unsigned char *messages = out->rows;
    for (uint32_t i = 0; i < h->rows.n; ++i)
        if (!stays[i])
            object_write_message(&h->form, messages + places[destinations[i]]++ * out->row_bytes,
                                 h->rows.ids[i], object_row(&h->rows, &h->form, i));
}

// No rank lets go of what left it before all have taken what came.
static bool take_arrivals(homes *h, ranks *r, const bool *stays, const parcels *in,
                          uint64_t staying, duet_error *err)
{
    object_rows rows = {0};
    arrival *arrivals = arrivals_sort(&h->form, in->rows, in->n, err);
    bool ok = arrivals && object_rows_begin(&rows, &h->form, staying + in->n, err);
    ok = ok && object_rows_merge(&rows, &h->form, &h->rows, stays, arrivals, in->n, NULL, err);
    ok = ranks_agree(r, ok, err);
    free(arrivals);
    if (ok) {
        object_rows before = h->rows;
        h->rows = rows;
        rows = before;
    }
    object_rows_end(&rows);
    return ok;
}

static bool move_leavers(homes *h, ranks *r, const cut *c, duet_error *err)
{
    int *destinations = malloc(((size_t)h->rows.n + 1) * sizeof *destinations);
    bool *stays = malloc(((size_t)h->rows.n + 1) * sizeof *stays);
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    parcels out = {0}, in = {0};
    uint64_t leaving = 0;
    bool ok = parcels_begin(&out, r, object_message_bytes(&h->form), err);
    if (ok && !(destinations && stays && places))
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "homes of %u objects: no memory", h->rows.n);
    if (ok)
        leaving = find_leavers(h, r, c, destinations, stays, out.counts);
    ok = ok && parcels_reserve(&out, r, places, err);
    if (ok)
        write_leavers(h, destinations, stays, places, &out);
    ok = ranks_exchange(r, ok, &out, &in, err);
    ok = ok && take_arrivals(h, r, stays, &in, h->rows.n - leaving, err);
    parcels_end(&in);
    parcels_end(&out);
    free(places);
    free(stays);
    free(destinations);
    return ok;
}

// ---------------------------------------------------------------- the cut

// The most objects that a rank has for those that its weight makes due to it.
static double find_unevenness(const homes *h, ranks *r, const cut *c)
{
    uint64_t n = h->rows.n;
    ranks_sum(r, &n, 1);
    double due = (double)n * (double)c->parts[r->self];
    double most = n > 0 && due > 0 ? h->rows.n / due : 1;
    ranks_greatest(r, &most, 1);
    return fmax(most, 1);
}

static bool cut_again(homes *h, ranks *r, cut *c, duet_error *err)
{
    if (!cut_make(c, r, &h->form, &h->rows, err) || !move_leavers(h, r, c, err))
        return false;
    h->unevenness = find_unevenness(h, r, c);
    h->is_cut = true;
    return true;
}

// ---------------------------------------------------------------- reaches

static bool measure(homes *h, ranks *r, duet_error *err)
{
    forget_extents(h);
    h->reaches = malloc(((size_t)h->rows.n + 1) * sizeof *h->reaches);
    h->levels = malloc((size_t)h->rows.n + 1);
    bool ok = h->reaches && h->levels;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "bounds of %u objects: no memory", h->rows.n);
    if (!ranks_agree(r, ok, err))
        return false;
    h->widest = 0;
    for (uint32_t i = 0; i < h->rows.n; ++i) {
        h->reaches[i] = reach_of(&h->form, object_row(&h->rows, &h->form, i));
        double width = reach_widest(&h->reaches[i]);
        h->widest = width > h->widest ? width : h->widest;
    }
    ranks_greatest(r, &h->widest, 1);
    for (uint32_t i = 0; i < h->rows.n; ++i)
        h->levels[i] = (uint8_t)level_of(reach_widest(&h->reaches[i]), h->widest);
    return true;
}

bool homes_settle(homes *h, ranks *r, cut *c, double imbalance, duet_error *err)
{
    bool ok = check_objects(h, r, err);
    if (ok && h->is_cut)
        ok = move_leavers(h, r, c, err);
    if (ok && (!h->is_cut || find_unevenness(h, r, c) > imbalance * h->unevenness))
        ok = cut_again(h, r, c, err);
    return ok && measure(h, r, err);
}
