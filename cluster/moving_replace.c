// SPDX-License-Identifier: MIT
// A domain's bodies and contacts, once all have come, become those of its motion.
#include "cluster/moving_domains.h"

#include "base/error.h"

// ---------------------------------------------------------------- order

static int compare_bodies(const void *left, const void *right)
{
    const moving_body *a = left, *b = right;
    return a->id < b->id ? -1 : a->id > b->id;
}

static int compare_contacts(const void *left, const void *right)
{
    const moving_contact *a = left, *b = right;
    if (a->owner != b->owner)
        return a->owner < b->owner ? -1 : 1;
    return a->other < b->other ? -1 : a->other > b->other;
}

// How many of the first bodies ascend: all that stayed do.
static uint64_t count_ascending(const moving *m, const item_list *bodies)
{
    uint64_t n = bodies->n > 0;
    while (n < bodies->n && moving_body_at(m, bodies, n - 1)->id < moving_body_at(m, bodies, n)->id)
        ++n;
    return n;
}

// The first of n bodies, which ascend, whose id is not below.
static uint64_t place_among(const moving *m, const item_list *bodies, uint64_t n, uint32_t id)
{
    uint64_t low = 0;
    while (low < n) {
        uint64_t middle = low + (n - low) / 2;
        if (moving_body_at(m, bodies, middle)->id < id)
            low = middle + 1;
        else
            n = middle;
    }
    return low;
}

// Merges n bodies that came with those that were there, from the last on: each moves once.
static void merge_bodies(const moving *m, item_list *bodies, uint64_t n_before, const char *came,
                         uint64_t n)
{
    for (uint64_t end = bodies->n; n > 0; --end) {
        const moving_body *last = (const void *)(came + (n - 1) * m->body_bytes);
        uint64_t place = place_among(m, bodies, n_before, last->id), moves = n_before - place;
        memmove(moving_body_at(m, bodies, end - moves), moving_body_at(m, bodies, place),
                moves * m->body_bytes);
        end -= moves;
        memcpy(moving_body_at(m, bodies, end - 1), last, m->body_bytes);
        n_before = place;
        --n;
    }
}

static bool sort_bodies(const moving *m, item_list *bodies)
{
    const uint64_t n_before = count_ascending(m, bodies), n = bodies->n - n_before;
    char *came = malloc(n * m->body_bytes + 1);
    if (came && n > 0) {
        memcpy(came, moving_body_at(m, bodies, n_before), n * m->body_bytes);
        qsort(came, n, m->body_bytes, compare_bodies);
        merge_bodies(m, bodies, n_before, came, n);
    }
    free(came);
    return came;
}

// Domains that each had an end of a contact send it to one that has both.
static void sort_contacts(const moving *m, item_list *c)
{
    uint64_t kept = 0;
    if (c->n > 0)
        qsort(c->items, c->n, m->contact_bytes, compare_contacts);
    for (uint64_t i = 0; i < c->n; ++i) {
        const moving_contact *one = moving_contact_at(m, c, i);
        if (kept == 0 || compare_contacts(moving_contact_at(m, c, kept - 1), one) != 0)
            memmove(moving_contact_at(m, c, kept++), one, m->contact_bytes);
    }
    c->n = kept;
}

uint32_t moving_place(const moving *m, const moving_domain *d, uint32_t id)
{
    const uint64_t place = place_among(m, &d->bodies, d->bodies.n, id);
    bool found = place < d->bodies.n && moving_body_at(m, &d->bodies, place)->id == id;
    return found ? (uint32_t)place : UINT32_MAX;
}

// ---------------------------------------------------------------- into the motions

typedef struct replacement {
    domain_bodies bodies;
    row_list waking; // own places that leant on what is not here
    domain_contacts contacts;
} replacement;

static uint32_t count_fresh(const moving *m, const moving_domain *d)
{
    uint32_t n = 0;
    for (uint64_t i = 0; i < d->bodies.n; ++i)
        n += moving_body_at(m, &d->bodies, i)->at == NO_PLACE;
    return n;
}

static bool reserve(const moving *m, const moving_domain *d, replacement *r, duet_error *own)
{
    domain_bodies *b = &r->bodies;
    const size_t n = d->bodies.n + FIXED;
    b->n = (uint32_t)d->bodies.n;
    b->n_fresh = count_fresh(m, d);
    b->poses = malloc(n * sizeof *b->poses);
    b->bodies = malloc(n * sizeof *b->bodies);
    b->from = malloc(n * sizeof *b->from);
    b->fresh = malloc((b->n_fresh + 1) * sizeof *b->fresh);
    b->states = malloc(b->n_fresh * (m->body_bytes - sizeof(moving_body)) + 1);
    r->contacts.n = (uint32_t)d->contacts.n;
    return domain_contacts_reserve(&r->contacts, d->motion, true, own) && b->poses && b->bodies &&
           b->from && b->fresh && b->states;
}

static void fill_bodies(const moving *m, const moving_domain *d, replacement *r)
{
    const size_t state = m->body_bytes - sizeof(moving_body);
    domain_bodies *to = &r->bodies;
    to->n_fresh = 0;
    for (uint32_t i = 0; i < to->n; ++i) {
        moving_body *b = moving_body_at(m, &d->bodies, i);
        b->complete = b->acts || m->n_domains == 1;
        to->poses[i] = b->pose;
        to->bodies[i] = b->body;
        to->from[i] = b->at;
        if (b->at != NO_PLACE)
            continue;
        memcpy(to->states + to->n_fresh * state, moving_state(b), state);
        to->fresh[to->n_fresh++] = i;
    }
    for (uint32_t k = 0; k < FIXED; ++k)
        to->from[to->n + k] = NO_PLACE;
}

// An own sleeper that leant on what is far away now wakes, as in match_contacts.cl.
static void wake_end(const moving *m, const moving_domain *d, const moving_contact *c,
                     uint32_t place, replacement *r)
{
    const duet_motion *motion = d->motion;
    uint32_t points = c->touch & TOUCH_POINTS;
    bool leant = (motion->effects & DUET_EFFECT_SLEEP) &&
                 domain_was_pushed(motion, (const float *)(const void *)(c + 1), points);
    cl_uint asleep = 0;
    if (!leant || !moving_owns(m, d, place))
        return;
    const char *rest = moving_state(moving_body_at(m, &d->bodies, place)) + domain_rest_at(motion);
    memcpy(&asleep, rest + sizeof(float), sizeof asleep);
    if (asleep & SLEEPS)
        row_list_add(&r->waking, place);
}

// A contact of which an end is not here any more is none: bounds that meet are here.
static void fill_contacts(const moving *m, const moving_domain *d, replacement *r)
{
    const size_t record = m->contact_bytes - sizeof(moving_contact);
    domain_contacts *to = &r->contacts;
    to->n = 0;
    for (uint64_t i = 0; i < d->contacts.n; ++i) {
        const moving_contact *c = moving_contact_at(m, &d->contacts, i);
        bool fixed = c->other >= m->n_all;
        uint32_t owner = moving_place(m, d, c->owner);
        uint32_t other =
            fixed ? (uint32_t)d->bodies.n + (c->other - m->n_all) : moving_place(m, d, c->other);
        if (owner == UINT32_MAX || other == UINT32_MAX) {
            wake_end(m, d, c, owner != UINT32_MAX ? owner : other, r);
            continue;
        }
        to->links[to->n] = (cl_uint2){{owner, other}};
        to->touches[to->n] = c->touch;
        to->colours[to->n] = c->colour;
        memcpy((char *)to->records + to->n++ * record, c + 1, record);
    }
}

// They have no rest.
static bool wake(moving_domain *d, const row_list *places, duet_error *own)
{
    const row_parts whole = {.words = {1}};
    float *rests = calloc(places->n + 1, sizeof *rests);
    if (!rests || places->failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "bodies that wake: no memory");
    else if (places->n > 0)
        domain_unpack_rows(d->motion, RESTS, &whole, places->rows, (uint32_t)places->n, rests, own);
    domain_await_rows(d->motion, own);
    free(rests);
    return is_well(own);
}

// The places that bodies get which were here before, as far as they still are.
static uint32_t *find_moved(const moving *m, const moving_domain *d)
{
    const uint32_t n = d->motion->n;
    uint32_t *moved = malloc(((size_t)n + FIXED) * sizeof *moved);
    uint64_t now = 0;
    for (uint32_t i = 0; moved && i < n; ++i) {
        while (now < d->bodies.n && moving_body_at(m, &d->bodies, now)->id < d->places[i].id)
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
    uint32_t *moved = find_moved(m, d);
    if (!moved)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u bodies: no memory", d->motion->n);
    else
        domain_keep_contacts(d->motion, moved, own);
    free(moved);
}

void moving_replace(moving *m, moving_domain *d, duet_error *own)
{
    replacement r = {0};
    sort_contacts(m, &d->contacts);
    if (!sort_bodies(m, &d->bodies))
        error_set(own, DUET_STATUS_NO_MEMORY, "bodies that came: no memory");
    if (is_well(own))
        keep_contacts(m, d, own);
    moving_keep_base(m, d->motion);
    if (!reserve(m, d, &r, own)) {
        error_set(own, DUET_STATUS_NO_MEMORY, "a domain of %u bodies: no memory",
                  (uint32_t)d->bodies.n);
    } else if (is_well(own)) {
        fill_bodies(m, d, &r);
        fill_contacts(m, d, &r);
        if (domain_replace_bodies(d->motion, &r.bodies, &r.contacts, own))
            wake(d, &r.waking, own);
    }
    free(r.bodies.poses);
    free(r.bodies.bodies);
    free(r.bodies.from);
    free(r.bodies.fresh);
    free(r.bodies.states);
    free(r.waking.rows);
    domain_contacts_free(&r.contacts);
}
