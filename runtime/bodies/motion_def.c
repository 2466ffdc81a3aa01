// SPDX-License-Identifier: MIT
// A motion is made of these, before there is one: defaults, and what is wrong with a def, a pose or
// a body.
#include "runtime/bodies/motion_def.h"

#include "base/error.h"
#include "runtime/bodies/ground_def.h"
#include "runtime/bodies/material.h"
#include "runtime/bodies/vector.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/opencl/device_pair.h"

#include <float.h>
#include <math.h>

enum { COOKIE = 0x0d0e7004 };

duet_body duet_default_body(void)
{
    return (duet_body){.mass = 1.0f, .group = UINT32_MAX, .mask = UINT32_MAX};
}

duet_motion_def duet_default_motion_def(void)
{
    duet_motion_def def = {
        .plan = duet_default_plan(NULL),
        .dims = 3,
        .dt = 1.0 / 60.0,
        .max_push_speed = 3.0,
        .restitution_threshold = 1.0,
        .sleep_speed = 0.05,
        .sleep_after = 0.5,
        .event_mask = UINT32_MAX,
        .cookie = COOKIE,
    };
    for (int i = 0; i < DUET_MATERIALS; ++i)
        def.materials[i] = material_of_rules();
    return def;
}

duet_motion_def duet_game_motion_def(duet_device_pair *pair, uint32_t dims)
{
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.dims = dims;
    def.wants = DUET_EFFECT_GRAVITY | DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_FRICTION |
                DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_CONTINUOUS | DUET_EFFECT_FILTER |
                DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS | DUET_EFFECT_FORCES | DUET_EFFECT_SENSORS;
    def.gravity[dims == 2 ? 1 : 2] = -9.81;
    def.slop = 0.005;
    return def;
}

static bool is_between(double value, double least, double most)
{
    return value >= least && value <= most;
}

static bool check_numbers(const duet_motion_def *def, duet_error *err)
{
    const struct {
        const char *name;
        double value;
        double least;
        const char *right;
    } numbers[] = {
        {"dt", def->dt, 0.0, "0 or a time above it"},
        {"drag", def->drag, 0.0, "0 or above"},
        {"skin", def->skin, 0.0, "0 or a length above it"},
        {"slop", def->slop, 0.0, "0 or a length above it"},
        {"max_push_speed", def->max_push_speed, 0.0, "0 or a speed above it"},
        {"restitution_threshold", def->restitution_threshold, 0.0, "0 or a speed above it"},
        {"sleep_speed", def->sleep_speed, 0.0, "0 or a speed above it"},
        {"sleep_after", def->sleep_after, 0.0, "0 or a time above it"},
        {"hit_speed", def->hit_speed, 0.0, "0 or a speed above it"},
        {"attraction", def->attraction, -1e30, "a finite number"},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i)
        if (!is_between(numbers[i].value, numbers[i].least, 1e30))
            return bad_argument(err, "%s is %g; expected %s", numbers[i].name, numbers[i].value,
                                numbers[i].right);
    for (int k = 0; k < 3; ++k)
        if (!isfinite(def->gravity[k]) || !isfinite(def->centre[k]) || !isfinite(def->origin[k]))
            return bad_argument(err, "%c of gravity, centre or origin is not a finite number",
                                "xyz"[k]);
    return true;
}

static bool check_edge(const duet_motion_def *def, duet_error *err)
{
    for (uint32_t k = 0; def->boundary != DUET_BOUNDARY_NONE && k < def->dims; ++k)
        if (!isfinite(def->lower[k]) || !isfinite(def->upper[k]) || def->lower[k] >= def->upper[k])
            return bad_argument(err,
                                "the walls across %c are at %g and %g; expected finite and rising",
                                "xyz"[k], def -> lower[k], def -> upper[k]);
    return true;
}

// Refuses what origin cells do not go with.
static bool check_origin(const duet_motion_def *def, duet_error *err)
{
    if (!origin_is_edge(def->origin_edge))
        return bad_argument(err,
                            "origin_edge is %g; expected 0, or a power of two from 2^-100 to 2^100",
                            (double)def->origin_edge);
    if (def->origin_edge == 0.0f)
        return true;
    if (def->doubles)
        return bad_argument(err, "origin cells are for a state in float; expected doubles = false");
    return (def->boundary == DUET_BOUNDARY_NONE && def->attraction == 0.0) ||
           bad_argument(err, "walls, a periodic world and an attraction know no origin cells; "
                             "expected doubles, and no origin cells");
}

bool motion_check_def(const duet_motion_def *def, duet_error *err)
{
    if (!error_def(def && def->cookie == COOKIE, "motion", "duet_default_motion_def", err) ||
        !error_def_pair(def->pair, "motion", err) || !error_def_dims(def->dims, err))
        return false;
    if (def->substeps > 1000)
        return bad_argument(err, "substeps is %u; expected 0 (chosen for the scene), or 1 to 1000",
                            def->substeps);
    if (def->integrator > DUET_INTEGRATOR_YOSHIDA)
        return bad_argument(err, "integrator is %d; expected a duet_integrator",
                            (int)def->integrator);
    if (def->boundary > DUET_BOUNDARY_PERIODIC)
        return bad_argument(err, "boundary is %d; expected a duet_boundary", (int)def->boundary);
    if (def->doubles && !def->pair->devices[1].info.fp64)
        return bad_argument(err, "%s has no double; expected doubles = false",
                            def->pair->devices[1].info.selector);
    return check_numbers(def, err) && materials_check(def, err) && check_edge(def, err) &&
           check_origin(def, err) && ground_def_check(def, err);
}

const char *motion_pose_fault(const duet_pose *p, uint32_t dims)
{
    const float *q = p->rotation;
    double norm = (double)q[2] * q[2] + (double)q[3] * q[3];
    if (dims == 3)
        norm += (double)q[0] * q[0] + (double)q[1] * q[1];
    if (!vector_is_finite(p->centre, dims) || !vector_is_finite(p->half_extents, dims) ||
        !isfinite(norm))
        return "a number of its pose is not finite";
    for (uint32_t k = 0; k < dims; ++k)
        if (p->half_extents[k] < 0.0f)
            return "a half extent is negative";
    return norm > 0.0 ? NULL : "its rotation is zero";
}

const char *motion_body_fault(const duet_motion_def *def, const duet_body *b)
{
    if (!vector_is_finite(b->velocity, 3) || !vector_is_finite(b->angular_velocity, 3))
        return "a velocity or angular velocity is not finite";
    if (!vector_is_finite(b->surface_velocity, 3))
        return "the surface velocity is not finite";
    if (!is_between(b->mass, 0.0, 1e30) || (b->mass > 0.0f && b->mass < 1e-30f))
        return "the mass must be 0, or from 1e-30 to 1e30";
    if (!is_between(b->restitution, 0.0, 1.0))
        return "the restitution must be from 0 to 1";
    if (!is_between(b->radius, 0.0, FLT_MAX))
        return "the radius must be 0 or above";
    if (!is_between(b->rolling_resistance, 0.0, 1e6))
        return "the rolling resistance must be from 0 to 1e6";
    if (b->material > def->n_materials)
        return "it names a material that the def does not have";
    return is_between(b->friction, 0.0, 1e6) ? NULL : "the friction must be from 0 to 1e6";
}
