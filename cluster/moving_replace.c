// SPDX-License-Identifier: MIT
// A domain's bodies and contacts, once all have come, become those of its motion.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/row_order.h"

#include <inttypes.h>

static uint64_t key_of_traveller(const void *row)
{
    return ((const moving_traveller *)row)->body.id;
}

typedef struct replacement {
    domain_bodies bodies;
    moving_body *fresh; // [n_fresh], as are places
    domain_place *places;
    row_list waking; // own places that leant on what is not here
    domain_contacts contacts;
} replacement;

static bool reserve(const moving *m, const moving_domain *d, replacement *r, duet_error *own)
{
    domain_bodies *b = &r->bodies;
    b->n_fresh = (uint32_t)d->came.n;
    b->n = (uint32_t)(d->bodies.n - d->gone.n + d->came.n);
    const size_t n = (size_t)b->n_fresh + 1;
    b->from = malloc(((size_t)b->n + FIXED) * sizeof *b->from);
    b->fresh = malloc(n * sizeof *b->fresh);
    b->poses = malloc(n * sizeof *b->poses);
    b->bodies = malloc(n * sizeof *b->bodies);
    b->states = malloc(n * (m->traveller_bytes - sizeof(moving_traveller)));
    b->far_boxes = malloc(n * 6 * sizeof *b->far_boxes);
    r->fresh = malloc(n * sizeof *r->fresh);
    r->places = malloc(n * sizeof *r->places);
    r->contacts.n = (uint32_t)d->contacts.n;
    return domain_contacts_reserve(&r->contacts, d->motion, true, own) && b->from && b->fresh &&
           b->poses && b->bodies && b->states && b->far_boxes && r->fresh && r->places;
}

static void free_replacement(replacement *r)
{
    free(r->bodies.from);
    free(r->bodies.fresh);
    free(r->bodies.poses);
    free(r->bodies.bodies);
    free(r->bodies.states);
    free(r->bodies.far_boxes);
    free(r->fresh);
    free(r->places);
    free(r->waking.rows);
    domain_contacts_free(&r->contacts);
}

// Merges those that stay and those that came, by their ids.
static void merge(const moving *m, const moving_domain *d, domain_bodies *b)
{
    uint32_t at = 0, came = 0;
    uint64_t gone = 0;
    for (uint32_t i = 0; i <= d->bodies.n; ++i) {
        const bool is_end = i == d->bodies.n;
        if (!is_end && gone < d->gone.n && d->gone.rows[gone] == i) {
            ++gone;
            continue;
        }
        while (came < b->n_fresh &&
               (is_end || moving_traveller_at(m, &d->came, came)->body.id < d->bodies.rows[i].id)) {
            b->fresh[came++] = at;
            b->from[at++] = NO_PLACE;
        }
        if (!is_end)
            b->from[at++] = i;
    }
    for (uint32_t k = 0; k < FIXED; ++k)
        b->from[b->n + k] = NO_PLACE;
}

static void fill_fresh(const moving *m, const moving_domain *d, replacement *r)
{
    const size_t state = m->traveller_bytes - sizeof(moving_traveller);
    domain_bodies *to = &r->bodies;
    for (uint32_t i = 0; i < to->n_fresh; ++i) {
        moving_traveller *t = moving_traveller_at(m, &d->came, i);
        t->body.next = t->body.own;
        t->body.complete = t->body.acts || m->n_domains == 1;
        r->fresh[i] = t->body;
        r->places[i] = moving_place_of(d, &t->body, &t->given);
        to->poses[i] = t->pose;
        to->bodies[i] = t->given;
        memcpy(to->far_boxes + 6 * (size_t)i, t->far_box, sizeof t->far_box);
        memcpy(to->states + i * state, moving_state(t), state);
    }
}

static bool grow(moving_domain *d, uint64_t n, duet_error *own)
{
    const uint64_t most = n > d->bodies.n ? n : d->bodies.n;
    moving_body *rows = realloc(d->bodies.rows, (most + 1) * sizeof *rows);
    d->bodies.rows = rows ? rows : d->bodies.rows;
    d->bodies.capacity = rows ? most + 1 : d->bodies.capacity;
    if (!rows)
        return no_memory(own, "a domain of %" PRIu64 " bodies", n);
    return moving_reserve_places(d, most, own);
}

// An own sleeper that leant on what is far away now wakes, as in match_contacts.cl.
static void wake_end(const moving_domain *d, const moving_contact *c, uint32_t place,
                     replacement *r)
{
    const duet_motion *motion = d->motion;
    uint32_t points = c->touch & TOUCH_POINTS;
    bool leant = (motion->effects & DUET_EFFECT_SLEEP) &&
                 domain_was_pushed(motion, (const float *)(const void *)(c + 1), points);
    if (leant && moving_owns(d, place))
        row_list_add(&r->waking, place);
}

// A contact of which an end is not here any more is none: bounds that meet are here.
static void fill_contacts(const moving *m, const moving_domain *d, replacement *r)
{
    r->contacts.n = 0;
    for (uint64_t i = 0; i < d->contacts.n; ++i) {
        const moving_contact *c = moving_contact_at(m, &d->contacts, i);
        const uint32_t owner = moving_place(d, c->owner), other = moving_end_place(m, d, c->other);
        if (owner == UINT32_MAX || other == UINT32_MAX)
            wake_end(d, c, owner != UINT32_MAX ? owner : other, r);
        else
            moving_put_contact(m, c, owner, other, &r->contacts);
    }
}

// Leaves those that sleep.
static bool leave_sleepers(moving_domain *d, row_list *places, cl_uint *asleep, duet_error *own)
{
    uint64_t n = 0;
    if (!domain_pack_rows(d->motion, ASLEEP, NULL, places->rows, (uint32_t)places->n, asleep, own))
        return false;
    for (uint64_t i = 0; i < places->n; ++i)
        if (asleep[i] & SLEEPS)
            places->rows[n++] = places->rows[i];
    places->n = n;
    return true;
}

// They have no rest.
static bool wake(moving_domain *d, row_list *places, duet_error *own)
{
    if (places->n == 0)
        return true;
    cl_uint *rests = malloc(places->n * sizeof *rests);
    if (!rests || places->failed)
        no_memory(own, "bodies that wake");
    else if (leave_sleepers(d, places, rests, own)) {
        memset(rests, 0, places->n * sizeof *rests);
        domain_unpack_rows(d->motion, RESTS, NULL, places->rows, (uint32_t)places->n, rests, own);
        domain_await_rows(d->motion, own);
    }
    free(rests);
    return is_well(own);
}

// The places that bodies get which were here before, as far as they still are.
static uint32_t *find_moved(const moving_domain *d)
{
    const uint32_t n = d->motion->n;
    uint32_t *moved = malloc(((size_t)n + FIXED) * sizeof *moved);
    uint64_t now = 0;
    for (uint32_t i = 0; moved && i < n; ++i) {
        while (now < d->bodies.n && d->bodies.rows[now].id < d->places[i].id)
            ++now;
        moved[i] = (uint32_t)now;
    }
    for (uint32_t k = 0; moved && k < FIXED; ++k)
        moved[n + k] = (uint32_t)d->bodies.n + k;
    return moved;
}

// Contacts that do not travel stay.
static void keep_contacts(const moving *m, const moving_domain *d, duet_error *own)
{
    if (moving_sends_all(m) || d->motion->graph.n_contacts == 0) {
        domain_drop_contacts(d->motion);
        return;
    }
    uint32_t *moved = find_moved(d);
    if (!moved)
        no_memory(own, "%u bodies", d->motion->n);
    else
        domain_keep_contacts(d->motion, moved, own);
    free(moved);
}

static void find_carrier(const moving *m, const moving_domain *d)
{
    const uint32_t place = moving_carrier_place(m, d);
    if (place != UINT32_MAX)
        domain_set_carrier(d->motion, place);
}

// A grid that bodies left has them all in its border cells.
static void follow(const moving *m, moving_domain *d)
{
    if (!m->reaches || !extent_has_moved(&d->fitted, &m->reaches[d->number]))
        return;
    motion_refit_grid(d->motion);
    d->fitted = m->reaches[d->number];
}

// Places stay as they were until contacts are kept.
static void replace(moving *m, moving_domain *d, replacement *r, duet_error *own)
{
    const domain_bodies *b = &r->bodies;
    merge(m, d, &r->bodies);
    fill_fresh(m, d, r);
    d->n_own = (uint32_t)(d->bodies.n - d->gone.n + d->n_came_own);
    domain_splice(b, d->bodies.rows, r->fresh, sizeof *r->fresh);
    d->bodies.n = b->n;
    moving_index_places(m, d, own);
    find_carrier(m, d);
    keep_contacts(m, d, own);
    domain_splice(b, d->places, r->places, sizeof *r->places);
    moving_note_fixed(m, d, b->n);
    fill_contacts(m, d, r);
    if (is_well(own) && domain_keep_far_boxes(d->motion, own) &&
        domain_replace_bodies(d->motion, b, &r->contacts, own))
        wake(d, &r->waking, own);
}

void moving_replace(moving *m, moving_domain *d, duet_error *own)
{
    replacement r = {0};
    if (!moving_order_contacts(m, &d->contacts) ||
        !row_order(&d->came, m->traveller_bytes, key_of_traveller))
        no_memory(own, "what came to a domain");
    moving_keep_base(m, d->motion);
    follow(m, d);
    if (is_well(own) && !reserve(m, d, &r, own))
        no_memory(own, "a domain of %u bodies", r.bodies.n);
    else if (is_well(own) && grow(d, r.bodies.n, own))
        replace(m, d, &r, own);
    free_replacement(&r);
}
