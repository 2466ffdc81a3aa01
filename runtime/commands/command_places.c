// SPDX-License-Identifier: MIT
// Commands put bodies elsewhere: poses hold at once, and targets are where the next step takes
// bodies without mass.
#include "base/error.h"
#include "runtime/bodies/vector.h"
#include "runtime/commands/command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- poses

bool act_set_poses(duet_motion *m, command *c, duet_error *err)
{
    if (!motion_forget_targets(m, c->places, c->list.n, err))
        return false;
    command_keep_poses(m, c);
    return motion_send_places(m, c->places, c->list.n, PART_POSE | PART_SIZE, err) &&
           motion_wake_places(m, c->places, c->list.n, err);
}

bool check_set_poses(duet_motion *m, command *c, duet_error *err)
{
    if (!command_copy(m, c, err))
        return false;
    if (c->list.n > 0)
        memcpy(c->poses, c->rows, c->list.n * sizeof *c->poses);
    return command_check(m, c, PART_POSE, err) && command_settle(m, c, err);
}

// ---------------------------------------------------------------- targets

// The steady angular velocity that turns `from` into `to` in the time.
static void turn_between(const double from[4], const double to[4], double time, float velocity[3])
{
    const double norm = sqrt(vector_dot(to, to, 4) * vector_dot(from, from, 4));
    double v[3], across[3], w = vector_dot(to, from, 4) / norm;
    vector_cross(from, to, across);
    for (int k = 0; k < 3; ++k) // to * conjugate(from)
        v[k] = (from[3] * to[k] - to[3] * from[k] + across[k]) / norm;
    double sine = sqrt(vector_dot(v, v, 3));
    double angle = 2.0 * atan2(sine, fabs(w)) * (w < 0.0 ? -1.0 : 1.0);
    for (int k = 0; k < 3; ++k)
        velocity[k] = sine > 0.0 ? (float)(v[k] / sine * angle / time) : 0.0f;
}

// The velocities that take bodies from their states [n] to their targets in a step.
static void set_velocities(const duet_motion *m, const command *c, const duet_state *states)
{
    for (uint32_t i = 0; i < c->list.n; ++i) {
        const duet_state *s = &states[i];
        const float *q = c->poses[i].rotation;
        const double to[4] = {q[0], q[1], q[2], q[3]};
        for (uint32_t k = 0; k < m->def.dims; ++k) {
            double base =
                c->cells ? (double)c->cells[i].s[k] * (double)m->def.origin_edge : m->def.origin[k];
            c->bodies[i].velocity[k] =
                (float)((base + (double)c->poses[i].centre[k] - s->centre[k]) / m->def.dt);
        }
        turn_between(s->rotation, to, m->def.dt, c->bodies[i].angular_velocity);
    }
}

static bool find_velocities(duet_motion *m, const command *c, duet_error *err)
{
    const uint32_t n = c->list.n;
    duet_state *states = malloc(n * sizeof *states + 1);
    bool ok = states || no_memory(err, "%u states in %s", n, c->call);
    ok = ok && motion_fetch_states(m, c->places, n, states, NULL, err);
    if (ok)
        set_velocities(m, c, states);
    free(states);
    return ok;
}

static bool check_kinematic(const duet_motion *m, const command *c, duet_error *err)
{
    if (m->def.dt == 0.0)
        return bad_argument(err, "%s: dt is 0; expected steps that take a time", c->call);
    for (uint32_t i = 0; i < c->list.n; ++i)
        if (c->bodies[i].mass > 0.0f)
            return command_fail(c, i, DUET_STATUS_BAD_ARGUMENT, err,
                                "it has a mass of %g; expected one of mass 0",
                                (double)c->bodies[i].mass);
    return true;
}

// A pose may be too far away for a step.
static bool check_velocities(const duet_motion *m, const command *c, duet_error *err)
{
    for (uint32_t i = 0; i < c->list.n; ++i) {
        const char *fault = motion_body_fault(&m->def, &c->bodies[i]);
        if (fault)
            return command_fail(c, i, DUET_STATUS_BAD_OBJECT, err, "to get there, %s", fault);
    }
    return true;
}

bool act_set_targets(duet_motion *m, command *c, duet_error *err)
{
    motion_commands *left = m->commands;
    const duet_transform *targets = c->rows;
    const uint32_t n = c->list.n;
    motion_target *more = realloc(left->targets, ((size_t)left->n_targets + n + 1) * sizeof *more);
    if (!more)
        return no_memory(err, "%u targets", n);
    left->targets = more;
    for (uint32_t i = 0; i < n; ++i) {
        left->targets[left->n_targets++] = (motion_target){c->places[i], targets[i]};
        m->bodies[c->places[i]] = c->bodies[i];
    }
    return motion_send_places(m, c->places, n, PART_VELOCITY | PART_ANGULAR_VELOCITY, err) &&
           motion_wake_places(m, c->places, n, err);
}

bool check_set_targets(duet_motion *m, command *c, duet_error *err)
{
    const duet_transform *targets = c->rows;
    if (!command_copy(m, c, err))
        return false;
    for (uint32_t i = 0; i < c->list.n; ++i)
        c->poses[i] = motion_aim(m, c->poses[i], &targets[i]);
    return check_kinematic(m, c, err) && command_check(m, c, PART_POSE, err) &&
           command_settle(m, c, err) && find_velocities(m, c, err) && check_velocities(m, c, err);
}
