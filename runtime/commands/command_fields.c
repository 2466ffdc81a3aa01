// SPDX-License-Identifier: MIT
// Sets fields of bodies and of the world while a motion runs.
#include "runtime/commands/command.h"

#include "base/error.h"
#include "runtime/bodies/material.h"
#include "runtime/dynamics/motion_rows.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- fields

#define MEMBERS(first, last)    \
    offsetof(duet_body, first), \
        offsetof(duet_body, last) + sizeof((duet_body *)0)->last - offsetof(duet_body, first)

// By the bits of duet_body_field: the members from the first to the last, and what they change.
static const struct {
    const char *name;
    size_t at, size;
    uint32_t parts;
} fields[] = {
    {"velocity", MEMBERS(velocity, velocity), PART_VELOCITY},
    {"angular_velocity", MEMBERS(angular_velocity, angular_velocity), PART_ANGULAR_VELOCITY},
    {"mass", MEMBERS(mass, mass), PART_MASS},
    {"restitution", MEMBERS(restitution, restitution), PART_SURFACE},
    {"friction", MEMBERS(friction, friction), PART_SURFACE},
    {"filter", MEMBERS(group, mask), PART_FILTER},
    {"fixed_rotation", MEMBERS(fixed_rotation, fixed_rotation), PART_MASS},
    {"radius", MEMBERS(radius, radius), PART_SIZE},
    {"rolling_resistance", MEMBERS(rolling_resistance, rolling_resistance), PART_SURFACE},
    {"surface_velocity", MEMBERS(surface_velocity, surface_velocity), PART_SURFACE},
    {"material", MEMBERS(material, material), PART_SURFACE},
};

enum { N_FIELDS = sizeof fields / sizeof fields[0] };

const char *duet_body_field_name(uint32_t field)
{
    for (int i = 0; i < N_FIELDS; ++i)
        if (field == 1u << i)
            return fields[i].name;
    return NULL;
}

static void copy_fields(duet_body *to, const duet_body *from, uint32_t which)
{
    for (int i = 0; i < N_FIELDS; ++i)
        if (which & 1u << i)
            memcpy((char *)to + fields[i].at, (const char *)from + fields[i].at, fields[i].size);
}

static uint32_t parts_of(uint32_t which)
{
    uint32_t all = 0;
    for (int i = 0; i < N_FIELDS; ++i)
        all |= which & 1u << i ? fields[i].parts : 0;
    return all;
}

// Contacts of one colour share no body that moves; contacts of a body that has a mass from now
// on may have done so. A wall has no place, nor has a contact in another domain.
static bool uncolour(duet_motion *m, const uint8_t *gained, duet_error *err)
{
    motion_rows links, colours;
    if (m->graph.n_contacts == 0 || !(m->effects & DUET_EFFECT_CONTACT_RESPONSE))
        return true;
    if (!motion_rows_of_words(m, LINKS, m->graph.n_contacts, 2, &links, err))
        return false;
    if (!motion_rows_of_words(m, COLOUR_OF, m->graph.n_contacts, 1, &colours, err)) {
        motion_rows_drop(&links);
        return false;
    }
    for (uint32_t i = 0; i < m->graph.n_contacts; ++i) {
        const uint32_t *link = motion_row(&links, i);
        for (int end = 0; end < 2; ++end)
            if (link[end] < m->n && gained[link[end]])
                *(uint32_t *)motion_row(&colours, i) = COLOUR_NONE;
    }
    motion_rows_drop(&links);
    return motion_rows_close(m, &colours, err);
}

// Whether each has a mass decides whose the contacts are.
static bool change_masses(duet_motion *m, const command *c, duet_error *err)
{
    uint8_t *gained = calloc((size_t)m->n + 1, 1);
    bool any = false;
    if (!gained)
        return no_memory(err, "%u places", m->n);
    for (uint32_t i = 0; i < c->list.n; ++i) {
        bool had = m->bodies[c->places[i]].mass > 0.0f, has = c->bodies[i].mass > 0.0f;
        if (had != has)
            motion_alter_places(m, &c->places[i], 1);
        gained[c->places[i]] |= has && !had;
        any |= has && !had;
    }
    bool ok = !any || uncolour(m, gained, err);
    free(gained);
    return ok;
}

bool act_set_bodies(duet_motion *m, command *c, duet_error *err)
{
    const uint32_t moving = DUET_BODY_VELOCITY | DUET_BODY_ANGULAR_VELOCITY | DUET_BODY_MASS;
    const uint32_t n = c->list.n;
    if (n == 0)
        return true;
    if ((c->fields & moving) && !motion_forget_targets(m, c->places, n, err))
        return false;
    if ((c->fields & DUET_BODY_MASS) && !change_masses(m, c, err))
        return false;
    if (c->fields & DUET_BODY_FILTER) {
        motion_alter_places(m, c->places, n);
        motion_forget_events(&m->told); // events are told by groups
    }
    for (uint32_t i = 0; i < n; ++i)
        copy_fields(&m->bodies[c->places[i]], &c->bodies[i], c->fields);
    return motion_send_places(m, c->places, n, parts_of(c->fields), err) &&
           motion_wake_places(m, c->places, n, err);
}

bool check_set_bodies(duet_motion *m, command *c, duet_error *err)
{
    const duet_body *given = c->rows;
    if (c->fields & ~(uint32_t)DUET_BODY_ALL)
        return bad_argument(err, "%s: fields is %#x; expected bits of duet_body_field", c->call,
                            c->fields);
    if (!command_copy(m, c, err))
        return false;
    for (uint32_t i = 0; i < c->list.n; ++i)
        copy_fields(&c->bodies[i], &given[i], c->fields);
    return command_check(m, c, parts_of(c->fields), err);
}

// ---------------------------------------------------------------- user data

CHECKS_ITS_LIST(set_user_data)

bool act_set_user_data(duet_motion *m, command *c, duet_error *err)
{
    const uint64_t *data = c->rows;
    (void)err;
    for (uint32_t i = 0; i < c->list.n; ++i)
        m->commands->user_data[c->places[i]] = data[i];
    return true;
}

// ---------------------------------------------------------------- the world

// That only the members differ which a command can change.
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
            return bad_argument(err, "%s: %s is %g; expected the motion's %g, which cannot change",
                                call, same[i].name, same[i].of, same[i].motion);
    if (!materials_are_same(a, b))
        return bad_argument(
            err, "%s: the materials are others; expected the motion's, which cannot change", call);
    if ((a->attraction != 0.0) != (b->attraction != 0.0))
        return bad_argument(
            err, "%s: the attraction is %g, the motion's %g; expected none or both to be 0", call,
            a->attraction, b->attraction);
    return a->pair == b->pair ||
           bad_argument(err, "%s: pair is another; expected the motion's, which cannot change",
                        call);
}

// The motion's ground, plan and chosen substeps stay.
static duet_motion_def def_of(const duet_motion *m, const command *c)
{
    duet_motion_def def = *(const duet_motion_def *)c->rows;
    if (def.substeps == 0)
        def.substeps = m->def.substeps;
    def.heights = m->def.heights;
    def.mesh = m->def.mesh;
    def.plan = m->def.plan;
    return def;
}

bool act_set_def(duet_motion *m, command *c, duet_error *err)
{
    m->def = def_of(m, c);
    motion_alter_all(m); // walls are elsewhere
    return motion_wake_all(m, err);
}

bool check_set_def(duet_motion *m, command *c, duet_error *err)
{
    const duet_motion_def def = def_of(m, c);
    return motion_check_def(&def, err) && check_same(&def, &m->def, c->call, err) &&
           motion_needs(m, effect_infer(&def, m->facts), c->call, err);
}
