// SPDX-License-Identifier: MIT
#include "cli/difference.h"

#include "base/error.h"
#include "runtime/dynamics/domain_motion.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

// -0 is 0, as in the state's hash; NaN is NaN.
static bool same(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

static bool same_hits(const duet_hit_event *a, const duet_hit_event *b, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i)
        if (a[i].a != b[i].a || a[i].b != b[i].b || a[i].speed != b[i].speed ||
            a[i].impulse != b[i].impulse)
            return false;
    return true;
}

static bool same_events(const duet_motion_result *x, const duet_motion_result *y)
{
    bool same_counts = x->contacts == y->contacts && x->n_events == y->n_events &&
                       x->n_stays == y->n_stays && x->n_hits == y->n_hits;
    for (uint64_t i = 0; same_counts && i < x->n_events; ++i)
        if (x->events[i].a != y->events[i].a || x->events[i].b != y->events[i].b ||
            x->events[i].begins != y->events[i].begins)
            return false;
    return same_counts && same_hits(x->hits, y->hits, x->n_hits);
}

bool difference_is(const verified_run runs[2], bool stepped)
{
    const verified_run *x = &runs[0], *y = &runs[1];
    return duet_motion_get_count(x->motion) != duet_motion_get_count(y->motion) ||
           x->not_finite.status != y->not_finite.status || x->hash != y->hash ||
           (stepped && !same_events(&x->last, &y->last));
}

bool difference_is_told(const verified_run runs[2])
{
    return !same_events(&runs[0].last, &runs[1].last);
}

// ---------------------------------------------------------------- naming

static uint64_t id_at(const verified_run *r, uint32_t place)
{
    uint64_t id = DUET_NO_BODY;
    if (place < duet_motion_get_count(r->motion))
        duet_motion_get_ids(r->motion, place, 1, &id, NULL);
    return id;
}

// Puts what differs in a stage, unless a body of a lesser id differs there, which is not always the
// first in its place, or something of the same body was put before.
static void put(difference *d, const char *stage, const char *field, uint64_t body, double a,
                double b)
{
    if (d->stage && body >= d->body)
        return;
    d->stage = stage;
    snprintf(d->field, sizeof d->field, "%s", field);
    d->body = body;
    d->values[0] = a;
    d->values[1] = b;
}

// The same of a contact, whose body a it is.
static void put_contact(difference *d, const verified_run *r, const char *stage, const char *what,
                        const duet_contact *of, double a, double b)
{
    const uint32_t n = duet_motion_get_count(r->motion), other = of->b;
    char field[sizeof d->field];
    if (other < n)
        snprintf(field, sizeof field, "%s with body %" PRIu64, what, id_at(r, other));
    else if (other < n + 6)
        snprintf(field, sizeof field, "%s with wall %u", what, other - n);
    else
        snprintf(field, sizeof field, "%s with the ground", what);
    put(d, stage, field, id_at(r, of->a), a, b);
}

// ---------------------------------------------------------------- states

static const char *const state_fields[] = {
    "centre.x",           "centre.y",           "centre.z",          "rotation.x", "rotation.y",
    "rotation.z",         "rotation.w",         "velocity.x",        "velocity.y", "velocity.z",
    "angular_velocity.x", "angular_velocity.y", "angular_velocity.z"};

enum { NUMBERS = sizeof state_fields / sizeof state_fields[0] };

static_assert(sizeof(duet_state) == NUMBERS * sizeof(double), "each number has a name");

// States that are not finite are states, too.
static duet_state *states_of(const verified_run *r, duet_error *err)
{
    duet_error why = {0};
    duet_state *states = malloc((duet_motion_get_count(r->motion) + (size_t)1) * sizeof *states);
    if (!states)
        return null_no_memory(err, "the states to compare");
    if (duet_motion_get_states(r->motion, states, &why) || why.status == DUET_STATUS_BAD_OBJECT)
        return states;
    free(states);
    error_copy(err, &why);
    return NULL;
}

static void note_states(difference *d, const verified_run *r, const char *stage,
                        const duet_state *x, const duet_state *y, uint32_t n)
{
    const double *a = (const double *)x, *b = (const double *)y;
    for (size_t i = 0; i < (size_t)n * NUMBERS; ++i)
        if (!same(a[i], b[i]))
            put(d, stage, state_fields[i % NUMBERS], id_at(r, (uint32_t)(i / NUMBERS)), a[i], b[i]);
}

bool difference_find_state(difference *d, const verified_run runs[2], const char *stage,
                           duet_error *err)
{
    uint32_t n[2] = {duet_motion_get_count(runs[0].motion), duet_motion_get_count(runs[1].motion)};
    duet_state *x = states_of(&runs[0], err);
    duet_state *y = x ? states_of(&runs[1], err) : NULL;
    if (y)
        note_states(d, &runs[0], stage, x, y, n[0] < n[1] ? n[0] : n[1]);
    if (y && n[0] != n[1])
        put(d, stage, "places", DUET_NO_BODY, n[0], n[1]);
    free(x);
    free(y);
    return y;
}

// ---------------------------------------------------------------- contacts

typedef struct contact_list {
    duet_contact *contacts;
    uint64_t n;
} contact_list;

static int order_of(const duet_contact *x, const duet_contact *y)
{
    if (x->a != y->a)
        return x->a < y->a ? -1 : 1;
    return x->b == y->b ? 0 : x->b < y->b ? -1 : 1;
}

static bool note_number(difference *d, const verified_run *r, const char *stage, const char *what,
                        const duet_contact *of, double a, double b)
{
    if (same(a, b))
        return false;
    put_contact(d, r, stage, what, of, a, b);
    return true;
}

static void note_manifold(difference *d, const verified_run *r, const duet_contact *x,
                          const duet_contact *y)
{
    bool found = false;
    for (int k = 0; !found && k < 3; ++k)
        found = note_number(d, r, "manifolds", "normal", x, x->normal[k], y->normal[k]);
    for (uint32_t i = 0; !found && i < x->n; ++i) {
        found = note_number(d, r, "manifolds", "separation", x, x->points[i].separation,
                            y->points[i].separation);
        for (int k = 0; !found && k < 3; ++k)
            found = note_number(d, r, "manifolds", "anchor", x, x->points[i].anchor[k],
                                y->points[i].anchor[k]);
    }
}

static void note_impulse(difference *d, const verified_run *r, const duet_contact *x,
                         const duet_contact *y)
{
    bool found = false;
    for (uint32_t i = 0; !found && i < x->n; ++i)
        found = note_number(d, r, "solver", "impulse of the contact", x,
                            x->points[i].normal_impulse, y->points[i].normal_impulse);
}

// Contacts that one motion alone has, or that have other points.
static void note_touches(difference *d, const verified_run *r, const contact_list *x,
                         const contact_list *y)
{
    for (uint64_t i = 0, k = 0; i < x->n || k < y->n;) {
        const duet_contact *a = i < x->n ? &x->contacts[i] : NULL;
        const duet_contact *b = k < y->n ? &y->contacts[k] : NULL;
        const int order = a && b ? order_of(a, b) : a ? -1 : 1;
        if (order != 0 || a->n != b->n)
            put_contact(d, r, "contacts", "points of the contact", order <= 0 ? a : b,
                        order <= 0 ? a->n : NAN, order >= 0 ? b->n : NAN);
        i += order <= 0;
        k += order >= 0;
    }
}

typedef void note(difference *d, const verified_run *r, const duet_contact *x,
                  const duet_contact *y);

// The contacts of both are the same, if nothing was found before.
static void note_contacts(difference *d, const verified_run *r, note *differs,
                          const contact_list *x, const contact_list *y)
{
    const bool found = d->stage;
    for (uint64_t i = 0; !found && i < x->n; ++i)
        differs(d, r, &x->contacts[i], &y->contacts[i]);
}

static bool read_contacts(const verified_run *r, contact_list *list, duet_error *err)
{
    return !(duet_motion_get_effects(r->motion) & DUET_EFFECT_CONTACT) ||
           duet_motion_get_contacts(r->motion, &list->contacts, &list->n, err);
}

// ---------------------------------------------------------------- a step

static bool pushes(const verified_run *r)
{
    return duet_motion_get_effects(r->motion) & DUET_EFFECT_CONTACT_RESPONSE;
}

// The kinds of events in turn, as numbers of all.
static void note_events(difference *d, const duet_motion_result *x, const duet_motion_result *y)
{
    const struct {
        const char *name;
        uint64_t n[2];
    } counts[] = {{"contacts that push", {x->contacts, y->contacts}},
                  {"events", {x->n_events, y->n_events}},
                  {"stays", {x->n_stays, y->n_stays}},
                  {"hits", {x->n_hits, y->n_hits}}};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i)
        if (counts[i].n[0] != counts[i].n[1])
            put(d, "events", counts[i].name, DUET_NO_BODY, (double)counts[i].n[0],
                (double)counts[i].n[1]);
    if (!same_events(x, y))
        put(d, "events", "bodies of the events", DUET_NO_BODY, NAN, NAN);
}

// A row of a touching contact: its bodies, and the colour by which it is solved.
static uint32_t next_touching(const domain_contacts *c, uint32_t row)
{
    while (row < c->n && !(c->touches[row] & TOUCH_POINTS))
        ++row;
    return row;
}

static void note_colour(difference *d, const verified_run *r, const cl_uint2 *link, cl_uint a,
                        cl_uint b)
{
    const duet_contact of = {.a = link->s[0], .b = link->s[1]};
    if (a != b)
        put_contact(d, r, "colours", "colour of the contact", &of, a, b);
}

static bool note_colours(difference *d, const verified_run runs[2], duet_error *err)
{
    domain_contacts x = {0}, y = {0};
    bool ok = domain_read_contacts(runs[0].motion, false, &x, err) &&
              domain_read_contacts(runs[1].motion, false, &y, err);
    uint32_t i = ok ? next_touching(&x, 0) : 0, k = ok ? next_touching(&y, 0) : 0;
    for (; ok && i < x.n && k < y.n; i = next_touching(&x, i + 1), k = next_touching(&y, k + 1))
        note_colour(d, &runs[0], &x.links[i], x.colours[i], y.colours[k]);
    domain_contacts_free(&x);
    domain_contacts_free(&y);
    return ok;
}

static bool note_solved(difference *d, const verified_run runs[2], const contact_list *x,
                        const contact_list *y, duet_error *err)
{
    const verified_run *r = &runs[0];
    bool ok = !pushes(r) || d->stage || note_colours(d, runs, err);
    ok = ok && (!pushes(r) || d->stage || difference_find_state(d, runs, "solver", err));
    if (ok)
        note_contacts(d, r, note_impulse, x, y);
    if (ok && !d->stage)
        note_events(d, &runs[0].last, &runs[1].last);
    return ok;
}

// Contacts lie before what they push, and behind what flies free.
bool difference_find(difference *d, const verified_run runs[2], duet_error *err)
{
    const verified_run *r = &runs[0];
    contact_list x = {0}, y = {0};
    bool ok = read_contacts(&runs[0], &x, err) && read_contacts(&runs[1], &y, err);
    if (ok && !pushes(r))
        ok = difference_find_state(d, runs, "integration", err);
    if (ok && !d->stage)
        note_touches(d, r, &x, &y);
    if (ok)
        note_contacts(d, r, note_manifold, &x, &y);
    ok = ok && note_solved(d, runs, &x, &y, err);
    duet_free(x.contacts);
    duet_free(y.contacts);
    return ok;
}

// ---------------------------------------------------------------- telling

static void tell_value(text *to, double value)
{
    if (isnan(value))
        text_add(to, "none");
    else
        text_add(to, "%.17g", value);
}

void difference_tell(const difference *d, text *to)
{
    if (d->step == 0)
        text_add(to, "at the start, ");
    else
        text_add(to, "step %" PRIu64 ", ", d->step);
    text_add(to, "%s, ", d->stage);
    if (d->body != DUET_NO_BODY)
        text_add(to, "body %" PRIu64 ": ", d->body);
    text_add(to, "%s is ", d->field);
    tell_value(to, d->values[0]);
    text_add(to, " and ");
    tell_value(to, d->values[1]);
}
