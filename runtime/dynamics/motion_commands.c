// SPDX-License-Identifier: MIT
// What is set, pushed or aimed at while a motion runs.
#include "runtime/dynamics/motion_commands.h"

#include "base/error.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/recording.h"

#include <stdlib.h>
#include <string.h>

static const char *const field_names[] = {
    "velocity", "angular_velocity", "mass",           "restitution",
    "friction", "filter",           "fixed_rotation", "radius"};

enum { N_FIELDS = sizeof field_names / sizeof field_names[0] };

const char *duet_body_field_name(uint32_t field)
{
    for (int i = 0; i < N_FIELDS; ++i)
        if (field == 1u << i)
            return field_names[i];
    return NULL;
}

// ---------------------------------------------------------------- fields

static void copy_fields(duet_body *to, const duet_body *from, uint32_t fields)
{
    if (fields & DUET_BODY_VELOCITY)
        memcpy(to->velocity, from->velocity, sizeof to->velocity);
    if (fields & DUET_BODY_ANGULAR_VELOCITY)
        memcpy(to->angular_velocity, from->angular_velocity, sizeof to->angular_velocity);
    if (fields & DUET_BODY_MASS)
        to->mass = from->mass;
    if (fields & DUET_BODY_RESTITUTION)
        to->restitution = from->restitution;
    if (fields & DUET_BODY_FRICTION)
        to->friction = from->friction;
    if (fields & DUET_BODY_FILTER) {
        to->group = from->group;
        to->mask = from->mask;
    }
    if (fields & DUET_BODY_FIXED_ROTATION)
        to->fixed_rotation = from->fixed_rotation;
    if (fields & DUET_BODY_RADIUS)
        to->radius = from->radius;
}

static uint32_t parts_of(uint32_t fields)
{
    static const uint32_t parts[N_FIELDS] = {
        PART_VELOCITY, PART_ANGULAR_VELOCITY, PART_MASS, PART_SURFACE,
        PART_SURFACE,  PART_FILTER,           PART_MASS, PART_SIZE};
    uint32_t all = 0;
    for (int i = 0; i < N_FIELDS; ++i)
        all |= fields & 1u << i ? parts[i] : 0;
    return all;
}

// Contacts of one colour share no body that moves; those of a body that has a mass from now
// on may have done so.
static bool uncolour(duet_motion *m, const uint8_t *gained, duet_error *err)
{
    motion_rows links, colours;
    if (m->n_contacts == 0 || !(m->effects & DUET_EFFECT_CONTACT_RESPONSE))
        return true;
    if (!motion_rows_of_contacts(m, LINKS, 2, &links, err))
        return false;
    if (!motion_rows_of_contacts(m, COLOUR_OF, 1, &colours, err)) {
        motion_rows_drop(&links);
        return false;
    }
    for (uint32_t i = 0; i < m->n_contacts; ++i) {
        const uint32_t *link = motion_row(&links, i);
        if (gained[link[0]] || (link[1] < m->n && gained[link[1]]))
            *(uint32_t *)motion_row(&colours, i) = COLOUR_NONE;
    }
    motion_rows_drop(&links);
    return motion_rows_close(m, &colours, err);
}

// Whether each has a mass decides whose the contacts are.
static bool change_masses(duet_motion *m, const motion_placed *p, duet_error *err)
{
    uint8_t *gained = calloc((size_t)m->n + 1, 1);
    bool any = false;
    if (!gained)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u places", m->n);
    for (uint32_t i = 0; i < p->n; ++i) {
        bool had = m->bodies[p->places[i]].mass > 0.0f, has = p->bodies[i].mass > 0.0f;
        if (had != has)
            motion_alter_places(m, &p->places[i], 1);
        gained[p->places[i]] |= has && !had;
        any |= has && !had;
    }
    bool ok = !any || uncolour(m, gained, err);
    free(gained);
    return ok;
}

static bool set_fields(duet_motion *m, const motion_placed *p, uint32_t fields, duet_error *err)
{
    const uint32_t moving = DUET_BODY_VELOCITY | DUET_BODY_ANGULAR_VELOCITY | DUET_BODY_MASS;
    if (p->n == 0)
        return true;
    if ((fields & moving) && !motion_forget_targets(m, p->places, p->n, err))
        return false;
    if ((fields & DUET_BODY_MASS) && !change_masses(m, p, err))
        return false;
    if (fields & DUET_BODY_FILTER) {
        motion_alter_places(m, p->places, p->n);
        motion_forget_events(&m->told); // events are told by groups
    }
    for (uint32_t i = 0; i < p->n; ++i)
        copy_fields(&m->bodies[p->places[i]], &p->bodies[i], fields);
    return motion_send_places(m, p->places, p->n, parts_of(fields), err) &&
           motion_wake_places(m, p->places, p->n, err);
}

bool duet_motion_set_bodies(duet_motion *m, duet_body_list list, uint32_t fields,
                            const duet_body *bodies, duet_error *err)
{
    PUBLIC_CALL(err);
    if (fields & ~(uint32_t)DUET_BODY_ALL)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: fields is %#x; expected bits of "
                         "duet_body_field",
                         __func__, fields);
    if (list.n > 0 && !error_given(bodies, __func__, "bodies", err))
        return false;
    motion_placed p;
    bool ok = motion_placed_open(&p, m, list, false, __func__, err);
    for (uint32_t i = 0; ok && i < list.n; ++i)
        copy_fields(&p.bodies[i], &bodies[i], fields);
    ok = ok && motion_placed_check(m, &p, parts_of(fields), __func__, err) &&
         motion_placed_admit(m, &p, __func__, err) &&
         motion_keep_whole(m, set_fields(m, &p, fields, err));
    if (ok)
        motion_note_bodies(m, p.places, list.n, fields, p.bodies);
    motion_placed_close(&p);
    return ok;
}

// ---------------------------------------------------------------- sleep

// What has no mass moves on, as it never sleeps. The places that have some come first then.
static bool stop_all(duet_motion *m, uint32_t *places, uint32_t n, duet_error *err)
{
    uint32_t n_stopped = 0;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t place = places[i];
        if (!(m->bodies[place].mass > 0.0f))
            continue;
        motion_stop(m, place);
        places[i] = places[n_stopped];
        places[n_stopped++] = place;
    }
    return motion_send_places(m, places, n_stopped, PART_VELOCITY | PART_ANGULAR_VELOCITY, err);
}

// What is sent to sleep stands still from then on: what it would have met is not met.
static bool put_to(duet_motion *m, duet_body_list list, bool sleeps, const char *call,
                   duet_error *err)
{
    uint32_t *places = motion_places_of(m, list, true, call, err);
    bool ok = places && motion_needs(m, DUET_EFFECT_SLEEP, call, err) &&
              motion_keep_whole(m, (!sleeps || stop_all(m, places, list.n, err)) &&
                                       motion_set_asleep(m, places, list.n, sleeps, err));
    if (ok)
        motion_note(m, sleeps ? RECORDED_SLEEP : RECORDED_WAKE, places, list.n, NULL);
    free(places);
    return ok;
}

bool duet_motion_wake_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    PUBLIC_CALL(err);
    return put_to(m, list, false, __func__, err);
}

bool duet_motion_sleep_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    PUBLIC_CALL(err);
    return put_to(m, list, true, __func__, err);
}

// ---------------------------------------------------------------- the world

const duet_motion_def *duet_motion_get_def(const duet_motion *m)
{
    return m ? &m->def : NULL;
}

static bool check_same(const duet_motion_def *a, const duet_motion_def *b, const char *call,
                       duet_error *err)
{
    const struct {
        const char *name;
        double of, motion;
    } same[] = {
        {"dims", a->dims, b->dims},
        {"wants", a->wants, b->wants},
        {"doubles", a->doubles, b->doubles},
        {"origin[0]", a->origin[0], b->origin[0]},
        {"origin[1]", a->origin[1], b->origin[1]},
        {"origin[2]", a->origin[2], b->origin[2]},
        {"origin_edge", a->origin_edge, b->origin_edge},
        {"boundary", a->boundary, b->boundary},
        {"dt", a->dt, b->dt},
        {"substeps", a->substeps, b->substeps},
        {"integrator", a->integrator, b->integrator},
        {"skin", a->skin, b->skin},
        {"slop", a->slop, b->slop},
        {"hit_speed", a->hit_speed, b->hit_speed},
        {"event_mask", a->event_mask, b->event_mask},
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i)
        if (same[i].of != same[i].motion)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: %s is %g; expected the motion's %g, which cannot change", call,
                             same[i].name, same[i].of, same[i].motion);
    return (a->attraction != 0.0) == (b->attraction != 0.0) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%s: the attraction is %g, the motion's %g; expected none or both to be 0",
                     call, a->attraction, b->attraction);
}

static bool change_world(duet_motion *m, const duet_motion_def *def, duet_error *err)
{
    const duet_plan plan = m->def.plan;
    m->def = *def;
    m->def.plan = plan;
    motion_alter_all(m); // walls are elsewhere
    return motion_wake_all(m, err);
}

bool duet_motion_set_def(duet_motion *m, const duet_motion_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !motion_check_def(def, err) ||
        !check_same(def, &m->def, __func__, err))
        return false;
    if (def->pair != m->def.pair)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: pair is another; expected the motion's, which cannot change",
                         __func__);
    bool ok = motion_needs(m, effect_infer(def, &m->facts), __func__, err) &&
              timeline_finish(&m->times, err) && motion_begin_commands(m, err) &&
              motion_keep_whole(m, change_world(m, def, err));
    if (ok)
        motion_note_def(m);
    return ok;
}
