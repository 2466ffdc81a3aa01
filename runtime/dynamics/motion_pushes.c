// SPDX-License-Identifier: MIT
// Forces for the next step, and impulses.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/recording.h"
#include "runtime/dynamics/vector.h"

#include <math.h>
#include <stdlib.h>

// ---------------------------------------------------------------- forces

static bool check_numbers(const void *of, size_t floats, uint32_t n, const char *call,
                          duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i)
        if (!vector_is_finite((const float *)of + i * floats, floats))
            return error_set(err, DUET_STATUS_BAD_OBJECT,
                             "%s: body %u of %u: a number is not finite", call, i, n);
    return true;
}

// Whether a number of a row is finite with so many times that much added. A list that names
// a body often adds at most that.
static bool stays_finite(const motion_rows *rows, uint32_t place, uint32_t k, double by, uint32_t n)
{
    double value = motion_row_get(rows, place, k) + n * by;
    return rows->doubles ? isfinite(value) : isfinite((float)value);
}

static bool too_much(const char *call, uint32_t i, uint32_t n, const char *what, duet_error *err)
{
    return error_set(err, DUET_STATUS_BAD_OBJECT, "%s: body %u of %u: %s would not be finite", call,
                     i, n, what);
}

// The eight numbers of a row, of those that the world has.
static void put_force(const duet_motion *m, const duet_force *force, float by[8])
{
    for (int k = 0; k < 3; ++k) {
        by[k] = k < (int)m->def.dims ? force->force[k] : 0.0f;
        by[4 + k] = m->def.dims == 3 || k == 2 ? force->torque[k] : 0.0f;
    }
    by[3] = by[7] = 0.0f;
}

static bool check_sums(const duet_motion *m, const motion_rows *rows, const uint32_t *places,
                       const duet_force *forces, uint32_t n, const char *call, duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i) {
        float by[8];
        put_force(m, &forces[i], by);
        for (uint32_t k = 0; k < 8; ++k)
            if (!stays_finite(rows, places[i], k, (double)by[k], n))
                return too_much(call, i, n, "the sum of its forces", err);
    }
    return true;
}

static bool write_forces(duet_motion *m, motion_rows *rows, const uint32_t *places,
                         const duet_force *forces, uint32_t n, duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i) {
        float *row = motion_row(rows, places[i]), by[8];
        put_force(m, &forces[i], by);
        for (int k = 0; k < 8; ++k)
            row[k] += by[k];
    }
    m->commands->pushed = true;
    return motion_rows_close(m, rows, err) && motion_wake_places(m, places, n, err);
}

static bool add_forces(duet_motion *m, const uint32_t *places, const duet_force *forces, uint32_t n,
                       const char *call, duet_error *err)
{
    motion_rows rows;
    if (n == 0)
        return true;
    if (!motion_rows_at(m, FORCES, places, n, &rows, err))
        return false;
    if (check_sums(m, &rows, places, forces, n, call, err))
        return motion_keep_whole(m, write_forces(m, &rows, places, forces, n, err));
    motion_rows_drop(&rows);
    return false;
}

bool duet_motion_apply_forces(duet_motion *m, duet_body_list list, const duet_force *forces,
                              duet_error *err)
{
    PUBLIC_CALL(err);
    if (list.n > 0 && !error_given(forces, __func__, "forces", err))
        return false;
    uint32_t *places = motion_places_of(m, list, true, __func__, err);
    bool ok = places && motion_needs(m, DUET_EFFECT_FORCES, __func__, err) &&
              check_numbers(forces, sizeof *forces / sizeof(float), list.n, __func__, err) &&
              add_forces(m, places, forces, list.n, __func__, err);
    if (ok)
        motion_note(m, RECORDED_FORCES, places, list.n, forces);
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

// What an impulse changes the angular velocity by, for a body with this rotation and
// inverse inertia along its own axes.
static void angular_change_of(const duet_motion *m, const duet_impulse *impulse, const double q[4],
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

// What impulses read and change. The last three are empty where nothing turns.
typedef struct pushed {
    motion_rows velocities, angular_velocities, rotations, inertias;
} pushed;

static bool open_pushed(duet_motion *m, const uint32_t *places, uint32_t n, pushed *p,
                        duet_error *err)
{
    return motion_rows_at(m, VELOCITIES, places, n, &p->velocities, err) &&
           (!(m->effects & DUET_EFFECT_ANGULAR_VELOCITY) ||
            (motion_rows_at(m, ROTATIONS, places, n, &p->rotations, err) &&
             motion_rows_at(m, INERTIAS, places, n, &p->inertias, err) &&
             motion_rows_at(m, ANGULAR_VELOCITIES, places, n, &p->angular_velocities, err)));
}

// By how much an impulse changes the velocity and the angular velocity of a place.
static void changes_of(const duet_motion *m, const pushed *p, uint32_t place,
                       const duet_impulse *impulse, double velocity[3], double angular_velocity[3])
{
    double per_mass = motion_row_get(&p->velocities, place, 3), q[4], inverse[3];
    for (uint32_t k = 0; k < 3; ++k) {
        velocity[k] = k < m->def.dims ? per_mass * (double)impulse->impulse[k] : 0.0;
        angular_velocity[k] = 0.0;
    }
    if (!p->angular_velocities.of)
        return;
    for (uint32_t k = 0; k < 4; ++k)
        q[k] = motion_row_get(&p->rotations, place, k);
    for (uint32_t k = 0; k < 3; ++k)
        inverse[k] = motion_row_get(&p->inertias, place, k);
    angular_change_of(m, impulse, q, inverse, angular_velocity);
}

static bool check_changes(const duet_motion *m, const pushed *p, const uint32_t *places,
                          const duet_impulse *impulses, uint32_t n, const char *call,
                          duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i) {
        double velocity[3], angular_velocity[3];
        changes_of(m, p, places[i], &impulses[i], velocity, angular_velocity);
        for (uint32_t k = 0; k < 3; ++k) {
            if (!stays_finite(&p->velocities, places[i], k, velocity[k], n))
                return too_much(call, i, n, "its velocity", err);
            if (p->angular_velocities.of &&
                !stays_finite(&p->angular_velocities, places[i], k, angular_velocity[k], n))
                return too_much(call, i, n, "its angular velocity", err);
        }
    }
    return true;
}

static void add_to(motion_rows *rows, uint32_t place, const double by[3])
{
    for (uint32_t k = 0; k < 3; ++k)
        motion_row_set(rows, place, k, motion_row_get(rows, place, k) + by[k]);
}

static bool push(duet_motion *m, pushed *p, const uint32_t *places, const duet_impulse *impulses,
                 uint32_t n, duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i) {
        double velocity[3], angular_velocity[3];
        changes_of(m, p, places[i], &impulses[i], velocity, angular_velocity);
        add_to(&p->velocities, places[i], velocity);
        if (p->angular_velocities.of)
            add_to(&p->angular_velocities, places[i], angular_velocity);
    }
    return motion_rows_close(m, &p->velocities, err) &&
           (!p->angular_velocities.of || motion_rows_close(m, &p->angular_velocities, err)) &&
           motion_wake_places(m, places, n, err);
}

static bool give_impulses(duet_motion *m, const uint32_t *places, const duet_impulse *impulses,
                          uint32_t n, const char *call, duet_error *err)
{
    pushed p = {0};
    if (n == 0)
        return true;
    bool ok = open_pushed(m, places, n, &p, err) &&
              check_changes(m, &p, places, impulses, n, call, err) &&
              motion_keep_whole(m, push(m, &p, places, impulses, n, err));
    motion_rows_drop(&p.velocities);
    motion_rows_drop(&p.angular_velocities);
    motion_rows_drop(&p.rotations);
    motion_rows_drop(&p.inertias);
    return ok;
}

bool duet_motion_apply_impulses(duet_motion *m, duet_body_list list, const duet_impulse *impulses,
                                duet_error *err)
{
    PUBLIC_CALL(err);
    if (list.n > 0 && !error_given(impulses, __func__, "impulses", err))
        return false;
    uint32_t *places = motion_places_of(m, list, true, __func__, err);
    bool ok = places && motion_needs(m, DUET_EFFECT_MOTION, __func__, err) &&
              check_numbers(impulses, sizeof *impulses / sizeof(float), list.n, __func__, err) &&
              give_impulses(m, places, impulses, list.n, __func__, err);
    if (ok)
        motion_note(m, RECORDED_IMPULSES, places, list.n, impulses);
    free(places);
    return ok;
}
