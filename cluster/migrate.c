// SPDX-License-Identifier: MIT
#include "cluster/migrate.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>

// An extent is a little wider the farther an object is from 0.
#define ROOM_TO_MOVE 1.01

// The sums and maxima of all ranks' classes.
typedef struct overview {
    uint64_t objects, bad, leavers;
    double widest;
    double unevenness; // the most objects that a rank has for those that its weight makes due to it
} overview;

static bool agree_on_classes(overview *v, const migration *m, bool ok, ranks *r, duet_error *err)
{
    const classes *c = &m->classes;
    uint32_t n = owned_count(m->owned);
    tally t = {.sums = {n, c->n_bad, c->leavers.n}, .greatest = {c->widest, n / m->partition->due}};
    if (!ranks_agree_and(r, ok, &t, err))
        return false;
    *v = (overview){t.sums[0], t.sums[1], t.sums[2], t.greatest[0], 1};
    if (v->objects > 0)
        v->unevenness = fmax(t.greatest[1] / (double)v->objects, 1);
    return true;
}

// The line is the same on all ranks, whichever owns the object.
static bool refuse_bad(const migration *m, const overview *v, ranks *r, duet_error *err)
{
    uint64_t first = m->classes.first_bad;
    ranks_least(r, &first, 1);
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %" PRIu64 " of %" PRIu64 " is not a number, infinite, negative or "
                     "without rotation (%" PRIu64 " such objects)",
                     first, v->objects, v->bad);
}

static bool no_memory_at_border(uint64_t n, duet_error *err)
{
    return no_memory(err, "%" PRIu64 " objects at the border", n);
}

static bool classify_all(migration *m, duet_error *err)
{
    return classify(&m->classes, m->owned) ||
           no_memory_at_border(m->owned->boundary.n + m->classes.leavers.n, err);
}

// Keeps the width that levels are relative to, until an object is wider or levels are too fine by
// far. Returns whether it did; the same on all ranks.
static bool keep_widest(owned *o, double widest)
{
    if (widest <= o->widest && o->widest <= 4 * widest)
        return true;
    o->widest = ROOM_TO_MOVE * widest;
    return false;
}

// ---------------------------------------------------------------- leavers

static int rank_of(const void *context, uint64_t k)
{
    const migration *m = context;
    const owned *o = m->owned;
    double centre[3];
    object_row_centre(&o->rows, &o->form, m->classes.leavers.rows[k], centre);
    return partition_rank(m->partition, centre);
}

static void write_leaver(const void *context, uint64_t k, void *message)
{
    const migration *m = context;
    const owned *o = m->owned;
    uint32_t row = m->classes.leavers.rows[k];
    object_write_message(&o->form, message, o->rows.ids[row], object_row(&o->rows, &o->form, row));
}

// A newcomer counts as a boundary object: it came through the boundary.
static void add_newcomer(owned *o, uint32_t row)
{
    const void *object = object_row(&o->rows, &o->form, row);
    double centre[3];
    extent e = extent_of(&o->form, object);
    object_centre(&o->form, object, centre);
    uint32_t d = owned_domain_at(o, centre);
    level_boxes_add(&o->boxes[d], &e, o->widest);
    row_list_add(&o->boundary, row);
    if (o->n_domains > 1)
        run_list_add(&o->runs, (row_run){.domain = d, .first = row, .n = 1});
    if (o->holder)
        row_list_add(&o->renamed, row);
}

// Releases the objects that leave once all ranks have taken those that came to them.
static bool exchange_leavers(migration *m, ranks *r, duet_error *err)
{
    owned *o = m->owned;
    uint32_t first = o->rows.n;
    parcels in = {0};
    const parcels_def out = {.n = m->classes.leavers.n,
                             .row_bytes = object_message_bytes(&o->form),
                             .write = write_leaver,
                             .rank_of = rank_of,
                             .context = m};
    bool ok = parcels_deal(r, is_well(err), &out, &in, err);
    ok = ok && ranks_agree(r, owned_add_newcomers(o, &in, err), err);
    parcels_end(&in);
    if (!ok) { // on any rank
        o->rows.n = first;
        return false;
    }
    row_list before = o->leavers;
    o->leavers = m->classes.leavers;
    m->classes.leavers = before;
    for (uint64_t k = 0; o->holder && k < o->leavers.n; ++k)
        row_list_add(&o->renamed, o->leavers.rows[k]);
    for (uint32_t row = first; row < o->rows.n; ++row)
        add_newcomer(o, row);
    return true;
}

// ---------------------------------------------------------------- partitioning

// Brings this rank's objects to its domains; not collective.
static bool place(migration *m, duet_error *err)
{
    owned_tidy(m->owned);
    return owned_place(m->owned, &m->partition->box, m->workers, err);
}

// Begins to send the rows of a single domain to its worker's devices, instead of what was sent
// before rows moved.
static bool send_ahead(owned *o, duet_error *err)
{
    if (!owned_map(o, err))
        return false;
    if (o->holder && o->placement == PLACED_BY_DOMAIN)
        o->holder->begin(o->holder, o->rows.n);
    return true;
}

// Brings all objects to their ranks by a new partition, and to their domains.
static bool partition_anew(migration *m, double widest, ranks *r, duet_error *err)
{
    owned *o = m->owned;
    overview v;
    owned_tidy(o);
    o->placement = PLACED_ANYHOW;
    owned_forget_domains(o);
    keep_widest(o, widest);
    if (!partition_make(m->partition, r, &o->form, &o->rows, err))
        return false;
    ++m->n_partitions;
    o->placement = PLACED_BY_RANK;
    o->domains[0].box = m->partition->box;
    classify_all(m, err);
    if (!agree_on_classes(&v, m, true, r, err) ||
        (v.leavers > 0 && (!exchange_leavers(m, r, err) || !agree_on_classes(&v, m, true, r, err))))
        return false;
    m->unevenness = v.unevenness;
    if (place(m, err) && send_ahead(o, err))
        classify_all(m, err);
    return true;
}

// ---------------------------------------------------------------- all of it

// Tidies the rows, and begins to send a single domain's rows to its worker's devices.
static bool begin(migration *m, duet_error *err)
{
    owned *o = m->owned;
    owned_tidy(o);
    bool is_due =
        o->placement == PLACED_BY_RANK || (o->placement == PLACED_BY_DOMAIN && owned_is_uneven(o));
    return (!is_due || place(m, err)) && send_ahead(o, err);
}

static void join_boxes(owned *o)
{
    for (uint32_t d = 0; d < o->n_domains; ++d)
        for (int k = 1; k < SIZE_LEVELS; ++k)
            extent_join(&o->boxes[d].upto[k], &o->boxes[d].upto[k - 1]);
}

bool migrate(migration *m, ranks *r, duet_error *err)
{
    owned *o = m->owned;
    overview v;
    bool has_begun = begin(m, err);
    if (has_begun)
        classify_all(m, err);
    if (!agree_on_classes(&v, m, has_begun, r, err))
        return false;
    if (v.bad > 0)
        return refuse_bad(m, &v, r, err);
    bool is_placed = o->placement != PLACED_ANYHOW;
    if (is_placed && !keep_widest(o, v.widest)) // levels are others
        classify_all(m, err);
    if (is_placed && v.leavers > 0 &&
        (!exchange_leavers(m, r, err) || !agree_on_classes(&v, m, true, r, err)))
        return false;
    if (o->boundary.failed) // with newcomers
        no_memory_at_border(o->boundary.n, err);
    if ((!is_placed || v.unevenness > m->imbalance * m->unevenness) &&
        !partition_anew(m, v.widest, r, err))
        return false;
    join_boxes(o);
    return true;
}
