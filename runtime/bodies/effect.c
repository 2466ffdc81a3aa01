// SPDX-License-Identifier: MIT
#include "runtime/bodies/effect.h"

#include "runtime/bodies/ground_def.h"
#include "runtime/bodies/material.h"

#include <math.h>

// An effect stands after those that it can be called for by.
static const effect_row rows[] = {
    {DUET_EFFECT_CONTACT_RESPONSE, "contact_response", DUET_EFFECT_CONTACT | DUET_EFFECT_MOTION,
     "a restitution or a friction, or wants", "pushes",
     "contact_graph, match_contacts, build_manifolds, graph_colour, colour_contacts, "
     "prepare_contacts, bodies, solve_contacts, solve_substeps, integrate_positions, "
     "contact_events"},
    {DUET_EFFECT_SENSORS, "sensors", DUET_EFFECT_EVENTS | DUET_EFFECT_CONTACT, "a sensor, or wants",
     "sensors", "contact_graph, build_manifolds, graph_colour, colour_contacts, update_sleep"},
    {DUET_EFFECT_EVENTS, "events", DUET_EFFECT_CONTACT, "wants, or a hit_speed", "touching",
     "contact_events"},
    {DUET_EFFECT_CONTACT, "contact", 0, "contact_response, or wants", NULL,
     "fat_aabbs, contact_graph, build_manifolds, match_contacts"},
    {DUET_EFFECT_MOTION, "motion", 0, "a velocity, gravity on a mass, or contact_response", NULL,
     "integrate_free_flight, or bodies"},
    {DUET_EFFECT_GRAVITY, "gravity", DUET_EFFECT_MOTION, "gravity or attraction, and a mass",
     "gravity", "integrate_free_flight, fat_aabbs, bodies, solve_substeps"},
    {DUET_EFFECT_FORCES, "forces", DUET_EFFECT_MOTION, "wants", "forces",
     "integrate_free_flight, bodies, solve_substeps"},
    {DUET_EFFECT_DRAG, "drag", DUET_EFFECT_MOTION, "drag, and a mass that moves", "drag",
     "integrate_free_flight, bodies, solve_substeps"},
    {DUET_EFFECT_BOUNDARY, "boundary", DUET_EFFECT_MOTION, "walls or a periodic world, and motion",
     "wall", "integrate_free_flight, contact_graph, build_manifolds"},
    {DUET_EFFECT_ANGULAR_VELOCITY, "angular_velocity", DUET_EFFECT_ROTATION | DUET_EFFECT_MOTION,
     "an angular velocity, contact_response for an object that may turn, or contact with a mesh "
     "that is carried",
     "angular_velocity",
     "integrate_free_flight, fat_aabbs, match_contacts, awake, build_manifolds, update_sleep, "
     "graph_colour, colour_contacts, prepare_contacts, bodies, solve_contacts, solve_substeps, "
     "integrate_positions, contact_events"},
    {DUET_EFFECT_ROTATION, "rotation", 0,
     "a rotation that is not the identity, with motion or contact; or angular_velocity",
     "rotations", "integrate_free_flight, fat_aabbs, build_manifolds"},
    {DUET_EFFECT_RADIUS, "radius", 0, "a radius, with contact or walls", "touch_rounded",
     "fat_aabbs, build_manifolds, bodies, solve_contacts, solve_substeps, integrate_free_flight"},
    {DUET_EFFECT_FRICTION, "friction", DUET_EFFECT_CONTACT_RESPONSE, "a friction", "friction",
     "match_contacts, build_manifolds, update_sleep, graph_colour, colour_contacts, "
     "prepare_contacts, solve_contacts, solve_substeps, integrate_positions, contact_events"},
    {DUET_EFFECT_ROLLING_RESISTANCE, "rolling_resistance",
     DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_RADIUS,
     "a rolling_resistance and a radius, with contact_response", "rolling_resistances",
     "prepare_contacts, solve_contacts, solve_substeps"},
    {DUET_EFFECT_SURFACE_VELOCITY, "surface_velocity",
     DUET_EFFECT_FRICTION | DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_ROTATION,
     "a surface_velocity, with friction", "surface_velocities",
     "prepare_contacts, solve_contacts, solve_substeps"},
    {DUET_EFFECT_MATERIALS, "materials", DUET_EFFECT_CONTACT_RESPONSE,
     "a body that names a material, with contact_response", "material_rules",
     "prepare_contacts, solve_substeps"},
    {DUET_EFFECT_SHOCKS, "shocks", DUET_EFFECT_CONTACT_RESPONSE, "wants", "shocked",
     "solve_shocks"},
    {DUET_EFFECT_DEPENETRATION, "depenetration", DUET_EFFECT_CONTACT_RESPONSE, "wants", NULL,
     "none: the host moves bodies once"},
    {DUET_EFFECT_CONTINUOUS, "continuous", DUET_EFFECT_CONTACT_RESPONSE,
     "something that moves, or whose corners swing, more than half its least half extent in a "
     "step, "
     "or a mesh that is carried",
     "swept",
     "fat_aabbs, build_manifolds, bodies, integrate_positions, solve_contacts, solve_substeps"},
    {DUET_EFFECT_FILTER, "filter", DUET_EFFECT_CONTACT, "a group or mask that is not all", "filter",
     "contact_graph"},
    {DUET_EFFECT_SLEEP, "sleep", DUET_EFFECT_CONTACT_RESPONSE, "wants", "asleep",
     "fat_aabbs, match_contacts, awake, build_manifolds, update_sleep, bodies, graph_colour, "
     "colour_contacts, integrate_positions, solve_substeps"},
    {DUET_EFFECT_GROUND, "ground", DUET_EFFECT_CONTACT, "heights or a mesh, with contact",
     "ground_origin", "contact_graph, build_manifolds"},
    {DUET_EFFECT_SKIN, "skin", DUET_EFFECT_CONTACT, "a skin above 0", "check_fat_aabbs",
     "fat_aabbs"},
};

enum { N_ROWS = sizeof rows / sizeof rows[0] };

const effect_row *effect_at(uint32_t i)
{
    return i < N_ROWS ? &rows[i] : NULL;
}

const char *duet_effect_name(uint32_t effect)
{
    for (int i = 0; i < N_ROWS; ++i)
        if (rows[i].effect == effect)
            return rows[i].name;
    return NULL;
}

// ---------------------------------------------------------------- facts

static bool is_zero(const float v[3], uint32_t dims)
{
    return v[0] == 0.0f && v[1] == 0.0f && (dims == 2 || v[2] == 0.0f);
}

static bool is_turned(const duet_pose *p, uint32_t dims)
{
    return p->rotation[2] != 0.0f ||
           (dims == 3 && (p->rotation[0] != 0.0f || p->rotation[1] != 0.0f));
}

// How far a body moves in a step, or a corner of it outside of the ball within it, in parts of
// that ball's radius.
static double reach_of(const duet_pose *p, const duet_body *b, uint32_t dims, double dt)
{
    const float *h = p->half_extents, *v = b->velocity, *w = b->angular_velocity;
    double speed = hypot(v[0], v[1]), least = fmin(h[0], h[1]), reach = hypot(h[0], h[1]);
    double turning = fabs(w[2]);
    if (dims == 3) {
        speed = hypot(speed, v[2]);
        least = fmin(least, h[2]);
        reach = hypot(reach, h[2]);
        turning = hypot(hypot(w[0], w[1]), w[2]);
    }
    speed += turning * (reach - least);
    return speed > 0.0 ? speed * dt / (least + b->radius) : 0.0;
}

static effect_facts facts_of_object(const duet_motion_def *def, const duet_pose *p,
                                    const duet_body *b)
{
    const uint32_t dims = def->dims;
    const float *h = p->half_extents;
    return (is_turned(p, dims) ? FACT_ROTATED : 0) |
           (!is_zero(b->velocity, dims) ? FACT_MOVING : 0) |
           (b->angular_velocity[2] != 0.0f || (dims == 3 && !is_zero(b->angular_velocity, 3))
                ? FACT_TURNING
                : 0) |
           (b->mass > 0.0f ? FACT_MASSIVE : 0) |
           (b->mass > 0.0f && !b->fixed_rotation ? FACT_TURNABLE : 0) |
           (dims == 3 && b->mass > 0.0f && (h[0] != h[1] || h[1] != h[2]) ? FACT_UNEVEN : 0) |
           (material_is_elastic(def, b) ? FACT_ELASTIC : 0) |
           (material_is_rough(def, b) ? FACT_ROUGH : 0) | (b->material > 0 ? FACT_MATERIAL : 0) |
           (b->rolling_resistance > 0.0f ? FACT_RESISTS : 0) |
           (!is_zero(b->surface_velocity, dims) ? FACT_CONVEYS : 0) |
           (b->sensor ? FACT_SENSING : 0) | (b->radius > 0.0f ? FACT_ROUND : 0) |
           (b->group != UINT32_MAX || b->mask != UINT32_MAX ? FACT_FILTERED : 0) |
           (reach_of(p, b, dims, def->dt) > 0.5 ? FACT_FAST : 0);
}

static effect_facts facts_of_ground(const duet_motion_def *def)
{
    const duet_body surface = {.material = ground_def_material(def)};
    return FACT_MATERIAL | (material_is_elastic(def, &surface) ? FACT_ELASTIC : 0) |
           (material_is_rough(def, &surface) ? FACT_ROUGH : 0);
}

void effect_facts_add(effect_facts *facts, const duet_motion_def *def, const duet_pose *poses,
                      const duet_body *bodies, uint32_t n)
{
    if (ground_def_material(def) > 0)
        *facts |= facts_of_ground(def);
    for (uint32_t i = 0; i < n; ++i)
        *facts |= facts_of_object(def, &poses[i], &bodies[i]);
}

// ---------------------------------------------------------------- inference

static effect_facts facts_of_def(const duet_motion_def *def)
{
    const double *g = def->gravity;
    const bool pulls =
        g[0] != 0.0 || g[1] != 0.0 || (def->dims == 3 && g[2] != 0.0) || def->attraction != 0.0;
    return (pulls ? FACT_PULLED : 0) | (def->drag > 0.0 ? FACT_DRAGGED : 0) |
           (def->boundary != DUET_BOUNDARY_NONE ? FACT_BOUNDED : 0) |
           (def->hit_speed > 0.0 ? FACT_HITS : 0) | (ground_def_is_given(def) ? FACT_GROUND : 0) |
           (ground_def_carrier(def) > 0 ? FACT_CARRIED : 0) | (def->skin > 0.0 ? FACT_SKIN : 0);
}

// An effect is called for by all of these facts, together with effects that are called for already.
// Effects without a row are wanted or needed only.
static const struct {
    uint32_t effect, beside;
    effect_facts facts;
} calls[] = {
    {DUET_EFFECT_CONTACT_RESPONSE, 0, FACT_MASSIVE | FACT_ELASTIC},
    {DUET_EFFECT_CONTACT_RESPONSE, 0, FACT_MASSIVE | FACT_ROUGH},
    {DUET_EFFECT_SENSORS, 0, FACT_SENSING},
    {DUET_EFFECT_EVENTS, 0, FACT_HITS},
    {DUET_EFFECT_MOTION, 0, FACT_MOVING},
    {DUET_EFFECT_MOTION, 0, FACT_TURNING},
    {DUET_EFFECT_MOTION, 0, FACT_MASSIVE | FACT_PULLED},
    {DUET_EFFECT_GRAVITY, 0, FACT_MASSIVE | FACT_PULLED},
    {DUET_EFFECT_DRAG, DUET_EFFECT_MOTION, FACT_MASSIVE | FACT_DRAGGED},
    {DUET_EFFECT_BOUNDARY, DUET_EFFECT_MOTION, FACT_BOUNDED},
    {DUET_EFFECT_ANGULAR_VELOCITY, 0, FACT_TURNING},
    {DUET_EFFECT_ANGULAR_VELOCITY, DUET_EFFECT_CONTACT_RESPONSE, FACT_TURNABLE},
    {DUET_EFFECT_ANGULAR_VELOCITY, DUET_EFFECT_CONTACT, FACT_CARRIED},
    {DUET_EFFECT_ROTATION, DUET_EFFECT_MOTION, FACT_ROTATED},
    {DUET_EFFECT_ROTATION, DUET_EFFECT_CONTACT, FACT_ROTATED},
    {DUET_EFFECT_RADIUS, DUET_EFFECT_CONTACT, FACT_ROUND},
    {DUET_EFFECT_RADIUS, DUET_EFFECT_BOUNDARY, FACT_ROUND},
    {DUET_EFFECT_FRICTION, DUET_EFFECT_CONTACT_RESPONSE, FACT_ROUGH},
    {DUET_EFFECT_ROLLING_RESISTANCE, DUET_EFFECT_CONTACT_RESPONSE, FACT_RESISTS | FACT_ROUND},
    {DUET_EFFECT_SURFACE_VELOCITY, DUET_EFFECT_FRICTION, FACT_CONVEYS},
    {DUET_EFFECT_MATERIALS, DUET_EFFECT_CONTACT_RESPONSE, FACT_MATERIAL},
    {DUET_EFFECT_CONTINUOUS, DUET_EFFECT_CONTACT_RESPONSE, FACT_FAST},
    {DUET_EFFECT_CONTINUOUS, DUET_EFFECT_CONTACT_RESPONSE, FACT_CARRIED},
    {DUET_EFFECT_FILTER, DUET_EFFECT_CONTACT, FACT_FILTERED},
    {DUET_EFFECT_GROUND, DUET_EFFECT_CONTACT, FACT_GROUND},
    {DUET_EFFECT_SKIN, DUET_EFFECT_CONTACT, FACT_SKIN},
};

static bool is_called(uint32_t effect, effect_facts facts, uint32_t so_far)
{
    bool called = false;
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i)
        called |=
            calls[i].effect == effect && !(calls[i].facts & ~facts) && !(calls[i].beside & ~so_far);
    return called;
}

// Twice, because effects that a later row needs may call for an earlier one.
uint32_t effect_infer(const duet_motion_def *def, effect_facts facts)
{
    uint32_t effects = 0;
    facts |= facts_of_def(def);
    for (int i = 0; i < 2 * N_ROWS; ++i) {
        const effect_row *row = &rows[i % N_ROWS];
        if (((effects | def->wants) & row->effect) || is_called(row->effect, facts, effects))
            effects |= row->effect | row->needs;
    }
    return effects;
}
