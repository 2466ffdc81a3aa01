// SPDX-License-Identifier: MIT
#include "cli/difference.h"

#include "base/error.h"

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

// ---------------------------------------------------------------- naming

static uint64_t id_at(const verified_run *r, uint32_t place)
{
    uint64_t id = DUET_NO_BODY;
    if (place < duet_motion_get_count(r->motion))
        duet_motion_get_ids(r->motion, place, 1, &id, NULL);
    return id;
}

static bool put(difference *d, const char *stage, uint64_t body, double a, double b)
{
    d->stage = stage;
    d->body = body;
    d->values[0] = a;
    d->values[1] = b;
    return true;
}

static void name_contact(difference *d, const char *what, const verified_run *r, uint32_t b)
{
    uint32_t n = duet_motion_get_count(r->motion);
    if (b < n)
        snprintf(d->field, sizeof d->field, "%s with body %" PRIu64, what, id_at(r, b));
    else if (b < n + 6)
        snprintf(d->field, sizeof d->field, "%s with wall %u", what, b - n);
    else
        snprintf(d->field, sizeof d->field, "%s with the ground", what);
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
        return error_null(err, DUET_STATUS_NO_MEMORY, "no memory for the states to compare");
    if (duet_motion_get_states(r->motion, states, &why) || why.status == DUET_STATUS_BAD_OBJECT)
        return states;
    free(states);
    error_copy(err, &why);
    return NULL;
}

static bool note_state(difference *d, const verified_run *r, const char *stage, const duet_state *x,
                       const duet_state *y, uint32_t n)
{
    const double *a = (const double *)x, *b = (const double *)y;
    for (size_t i = 0; i < (size_t)n * NUMBERS; ++i) {
        if (same(a[i], b[i]))
            continue;
        snprintf(d->field, sizeof d->field, "%s", state_fields[i % NUMBERS]);
        return put(d, stage, id_at(r, (uint32_t)(i / NUMBERS)), a[i], b[i]);
    }
    return false;
}

bool difference_find_state(difference *d, const verified_run runs[2], const char *stage,
                           duet_error *err)
{
    uint32_t n[2] = {duet_motion_get_count(runs[0].motion), duet_motion_get_count(runs[1].motion)};
    duet_state *x = states_of(&runs[0], err);
    duet_state *y = x ? states_of(&runs[1], err) : NULL;
    if (y && !note_state(d, &runs[0], stage, x, y, n[0] < n[1] ? n[0] : n[1]) && n[0] != n[1]) {
        snprintf(d->field, sizeof d->field, "places");
        put(d, stage, DUET_NO_BODY, n[0], n[1]);
    }
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

// The points of a contact that one motion alone has, or that has other points.
static bool note_touch(difference *d, const verified_run *r, const duet_contact *x,
                       const duet_contact *y)
{
    int order = x && y ? order_of(x, y) : x ? -1 : 1;
    const duet_contact *first = order <= 0 ? x : y;
    if (order == 0 && x->n == y->n)
        return false;
    name_contact(d, "points of the contact", r, first->b);
    return put(d, "contacts", id_at(r, first->a), order <= 0 ? x->n : NAN, order >= 0 ? y->n : NAN);
}

static bool note_number(difference *d, const verified_run *r, const char *stage, const char *what,
                        const duet_contact *of, double a, double b)
{
    if (same(a, b))
        return false;
    name_contact(d, what, r, of->b);
    return put(d, stage, id_at(r, of->a), a, b);
}

static bool note_manifold(difference *d, const verified_run *r, const duet_contact *x,
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
    return found;
}

static bool note_impulse(difference *d, const verified_run *r, const duet_contact *x,
                         const duet_contact *y)
{
    bool found = false;
    for (uint32_t i = 0; !found && i < x->n; ++i)
        found = note_number(d, r, "solver", "impulse of the contact", x,
                            x->points[i].normal_impulse, y->points[i].normal_impulse);
    return found;
}

typedef bool note(difference *d, const verified_run *r, const duet_contact *x,
                  const duet_contact *y);

// The first pair of contacts that differs. All but note_touch need equal lists.
static bool note_first(difference *d, const verified_run *r, note *differs, const contact_list *x,
                       const contact_list *y)
{
    for (uint64_t i = 0; i < x->n || i < y->n; ++i)
        if (differs(d, r, i < x->n ? &x->contacts[i] : NULL, i < y->n ? &y->contacts[i] : NULL))
            return true;
    return false;
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
    for (size_t i = 0; i < sizeof counts / sizeof counts[0] && !d->stage; ++i)
        if (counts[i].n[0] != counts[i].n[1]) {
            snprintf(d->field, sizeof d->field, "%s", counts[i].name);
            put(d, "events", DUET_NO_BODY, (double)counts[i].n[0], (double)counts[i].n[1]);
        }
    if (d->stage || same_events(x, y))
        return;
    snprintf(d->field, sizeof d->field, "bodies of the events");
    put(d, "events", DUET_NO_BODY, NAN, NAN);
}

// Contacts lie before what they push, and behind what flies free.
bool difference_find(difference *d, const verified_run runs[2], duet_error *err)
{
    const verified_run *r = &runs[0];
    contact_list x = {0}, y = {0};
    bool ok = read_contacts(&runs[0], &x, err) && read_contacts(&runs[1], &y, err);
    if (ok && !pushes(r))
        ok = difference_find_state(d, runs, "integration", err);
    bool found = !ok || d->stage || note_first(d, r, note_touch, &x, &y) ||
                 note_first(d, r, note_manifold, &x, &y);
    if (!found && pushes(r))
        ok = difference_find_state(d, runs, "solver", err);
    if (ok && !d->stage && !note_first(d, r, note_impulse, &x, &y))
        note_events(d, &runs[0].last, &runs[1].last);
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
