// SPDX-License-Identifier: MIT
// Forces for the next step, and impulses.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/vector.h"

#include <math.h>
#include <stdlib.h>

// ---------------------------------------------------------------- forces

static bool all_finite(const float *values, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(values[i]))
            return false;
    return true;
}

static bool check_numbers(const void *of, size_t floats, uint32_t n, const char *call,
                          duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i)
        if (!all_finite((const float *)of + i * floats, floats))
            return error_set(err, DUET_STATUS_BAD_OBJECT,
                             "%s: body %u of %u: a number is not finite", call, i, n);
    return true;
}

static bool add_forces(duet_motion *m, const uint32_t *places, const duet_force *forces, uint32_t n,
                       duet_error *err)
{
    uint32_t first, last;
    motion_rows rows;
    if (n == 0)
        return true;
    motion_span_of(places, n, &first, &last);
    if (!motion_rows_open(m, FORCES, first, last, 8, false, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i) {
        float *row = motion_row(&rows, places[i]);
        for (int k = 0; k < 3; ++k) {
            row[k] += k < (int)m->def.dims ? forces[i].force[k] : 0.0f;
            row[4 + k] += m->def.dims == 3 || k == 2 ? forces[i].torque[k] : 0.0f;
        }
    }
    m->commands->pushed = true;
    return motion_rows_close(m, &rows, err) && motion_wake_places(m, places, n, err);
}

bool duet_motion_apply_forces(duet_motion *m, duet_body_list list, const duet_force *forces,
                              duet_error *err)
{
    if (list.n > 0 && !error_given(forces, __func__, "forces", err))
        return false;
    uint32_t *places = motion_places_of(m, list, true, __func__, err);
    bool ok = places && motion_needs(m, DUET_EFFECT_FORCES, __func__, err) &&
              check_numbers(forces, sizeof *forces / sizeof(float), list.n, __func__, err) &&
              motion_keep_whole(m, add_forces(m, places, forces, list.n, err));
    free(places);
    return ok;
}

// ---------------------------------------------------------------- impulses

// v turned by q of length 1, or back.
static void turn(const double q[4], bool back, const double v[3], double to[3])
{
    double sign = back ? -1.0 : 1.0;
    const double u[3] = {sign * q[0], sign * q[1], sign * q[2]};
    double t[3], s[3];
    vector_cross(u, v, t);
    for (int k = 0; k < 3; ++k)
        t[k] *= 2.0;
    vector_cross(u, t, s);
    for (int k = 0; k < 3; ++k)
        to[k] = v[k] + q[3] * t[k] + s[k];
}

static bool push(duet_motion *m, const uint32_t *places, const duet_impulse *impulses, uint32_t n,
                 duet_error *err)
{
    uint32_t first, last;
    motion_rows rows;
    motion_span_of(places, n, &first, &last);
    if (!motion_rows_open(m, VELOCITIES, first, last, 4, true, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i) {
        double per_mass = motion_row_get(&rows, places[i], 3);
        for (uint32_t k = 0; k < m->def.dims; ++k)
            motion_row_set(&rows, places[i], k,
                           motion_row_get(&rows, places[i], k) +
                               per_mass * (double)impulses[i].impulse[k]);
    }
    return motion_rows_close(m, &rows, err);
}

// What an impulse changes the angular velocity by, for a body with this rotation and
// inverse inertia along its own axes.
static void spin_of(const duet_motion *m, const duet_impulse *impulse, const double q[4],
                    const double inverse[3], double by[3])
{
    bool solid = m->def.dims == 3;
    const double anchor[3] = {impulse->anchor[0], impulse->anchor[1],
                              solid ? impulse->anchor[2] : 0.0};
    const double force[3] = {impulse->impulse[0], impulse->impulse[1],
                             solid ? impulse->impulse[2] : 0.0};
    double torque[3], own[3];
    vector_cross(anchor, force, torque);
    turn(q, true, torque, own);
    for (int k = 0; k < 3; ++k)
        own[k] *= inverse[k];
    turn(q, false, own, by);
}

static bool twist(duet_motion *m, const uint32_t *places, const duet_impulse *impulses, uint32_t n,
                  duet_error *err)
{
    uint32_t first, last;
    motion_rows rows = {0}, rotations = {0}, inertias = {0};
    motion_span_of(places, n, &first, &last);
    bool ok = motion_rows_open(m, ROTATIONS, first, last, 4, true, &rotations, err) &&
              motion_rows_open(m, INERTIAS, first, last, 4, false, &inertias, err) &&
              motion_rows_open(m, ANGULAR_VELOCITIES, first, last, 4, true, &rows, err);
    for (uint32_t i = 0; ok && i < n; ++i) {
        double q[4], inverse[3], by[3];
        for (uint32_t k = 0; k < 4; ++k)
            q[k] = motion_row_get(&rotations, places[i], k);
        for (uint32_t k = 0; k < 3; ++k)
            inverse[k] = motion_row_get(&inertias, places[i], k);
        spin_of(m, &impulses[i], q, inverse, by);
        for (uint32_t k = 0; k < 3; ++k)
            motion_row_set(&rows, places[i], k, motion_row_get(&rows, places[i], k) + by[k]);
    }
    motion_rows_drop(&rotations);
    motion_rows_drop(&inertias);
    return ok && motion_rows_close(m, &rows, err);
}

static bool give_impulses(duet_motion *m, const uint32_t *places, const duet_impulse *impulses,
                          uint32_t n, duet_error *err)
{
    return n == 0 ||
           (push(m, places, impulses, n, err) &&
            (!motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY) || twist(m, places, impulses, n, err)) &&
            motion_wake_places(m, places, n, err));
}

bool duet_motion_apply_impulses(duet_motion *m, duet_body_list list, const duet_impulse *impulses,
                                duet_error *err)
{
    if (list.n > 0 && !error_given(impulses, __func__, "impulses", err))
        return false;
    uint32_t *places = motion_places_of(m, list, true, __func__, err);
    bool ok = places && motion_needs(m, DUET_EFFECT_MOTION, __func__, err) &&
              check_numbers(impulses, sizeof *impulses / sizeof(float), list.n, __func__, err) &&
              motion_keep_whole(m, give_impulses(m, places, impulses, list.n, err));
    free(places);
    return ok;
}
