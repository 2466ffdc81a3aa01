// SPDX-License-Identifier: MIT
// Forces for the next step, and impulses.
#include "runtime/bodies/vector.h"
#include "runtime/commands/command.h"
#include "runtime/dynamics/motion_rows.h"

#include <math.h>
#include <stdlib.h>

// ---------------------------------------------------------------- forces

// Rows are floats.
static bool check_numbers(const command *c, duet_error *err)
{
    const size_t floats = c->op->row / sizeof(float);
    for (uint32_t i = 0; i < c->list.n; ++i)
        if (!vector_is_finite((const float *)c->rows + i * floats, floats))
            return command_refuse(c, i, "a number is not finite", err);
    return true;
}

// Whether a number of a row is finite with so many times that much added. A list that names
// a body often adds at most that.
static bool stays_finite(const motion_rows *rows, uint32_t place, uint32_t k, double by, uint32_t n)
{
    double value = motion_row_get(rows, place, k) + n * by;
    return rows->doubles ? isfinite(value) : isfinite((float)value);
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

static bool check_sums(const duet_motion *m, const motion_rows *rows, const command *c,
                       duet_error *err)
{
    const duet_force *forces = c->rows;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        float by[8];
        put_force(m, &forces[i], by);
        for (uint32_t k = 0; k < 8; ++k)
            if (!stays_finite(rows, c->places[i], k, (double)by[k], command_count(c)))
                return command_refuse(c, i, "the sum of its forces would not be finite", err);
    }
    return true;
}

bool check_apply_forces(duet_motion *m, command *c, duet_error *err)
{
    motion_rows *rows = &c->pushed.forces;
    return c->list.n == 0 ||
           (check_numbers(c, err) && motion_rows_at(m, FORCES, c->places, c->list.n, rows, err) &&
            check_sums(m, rows, c, err));
}

bool act_apply_forces(duet_motion *m, command *c, duet_error *err)
{
    motion_rows *rows = &c->pushed.forces;
    const duet_force *forces = c->rows;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        float *row = motion_row(rows, c->places[i]), by[8];
        put_force(m, &forces[i], by);
        for (int k = 0; k < 8; ++k)
            row[k] += by[k];
    }
    m->commands->n_pushed += c->list.n;
    return c->list.n == 0 ||
           (motion_rows_close(m, rows, err) && motion_wake_places(m, c->places, c->list.n, err));
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

// Computes what an impulse changes the angular velocity by, for a body with this rotation and
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

static bool open_pushed(duet_motion *m, const command *c, command_pushed *p, duet_error *err)
{
    const uint32_t *places = c->places, n = c->list.n;
    return motion_rows_at(m, VELOCITIES, places, n, &p->velocities, err) &&
           (!(m->effects & DUET_EFFECT_ANGULAR_VELOCITY) ||
            (motion_rows_at(m, ROTATIONS, places, n, &p->rotations, err) &&
             motion_rows_at(m, INERTIAS, places, n, &p->inertias, err) &&
             motion_rows_at(m, ANGULAR_VELOCITIES, places, n, &p->angular_velocities, err)));
}

// By how much an impulse changes the velocity and the angular velocity of a place.
static void changes_of(const duet_motion *m, const command_pushed *p, uint32_t place,
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

static bool check_changes(const duet_motion *m, const command_pushed *p, const command *c,
                          duet_error *err)
{
    const duet_impulse *impulses = c->rows;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        const uint32_t place = c->places[i];
        double velocity[3], angular_velocity[3];
        changes_of(m, p, place, &impulses[i], velocity, angular_velocity);
        for (uint32_t k = 0; k < 3; ++k) {
            if (!stays_finite(&p->velocities, place, k, velocity[k], command_count(c)))
                return command_refuse(c, i, "its velocity would not be finite", err);
            if (p->angular_velocities.of && !stays_finite(&p->angular_velocities, place, k,
                                                          angular_velocity[k], command_count(c)))
                return command_refuse(c, i, "its angular velocity would not be finite", err);
        }
    }
    return true;
}

static void add_to(motion_rows *rows, uint32_t place, const double by[3])
{
    for (uint32_t k = 0; k < 3; ++k)
        motion_row_set(rows, place, k, motion_row_get(rows, place, k) + by[k]);
}

bool check_apply_impulses(duet_motion *m, command *c, duet_error *err)
{
    return c->list.n == 0 || (check_numbers(c, err) && open_pushed(m, c, &c->pushed, err) &&
                              check_changes(m, &c->pushed, c, err));
}

bool act_apply_impulses(duet_motion *m, command *c, duet_error *err)
{
    command_pushed *p = &c->pushed;
    const duet_impulse *impulses = c->rows;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        double velocity[3], angular_velocity[3];
        changes_of(m, p, c->places[i], &impulses[i], velocity, angular_velocity);
        add_to(&p->velocities, c->places[i], velocity);
        if (p->angular_velocities.of)
            add_to(&p->angular_velocities, c->places[i], angular_velocity);
    }
    return c->list.n == 0 ||
           (motion_rows_close(m, &p->velocities, err) &&
            (!p->angular_velocities.of || motion_rows_close(m, &p->angular_velocities, err)) &&
            motion_wake_places(m, c->places, c->list.n, err));
}
