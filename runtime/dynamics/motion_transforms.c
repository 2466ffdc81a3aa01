// SPDX-License-Identifier: MIT
// Where commands put bodies: poses hold at once, and targets are where the next step takes bodies
// without mass.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/recording.h"
#include "runtime/dynamics/vector.h"
#include "runtime/narrowphase/origin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- poses

void motion_stop(duet_motion *m, uint32_t place)
{
    memset(m->bodies[place].velocity, 0, sizeof m->bodies[place].velocity);
    memset(m->bodies[place].angular_velocity, 0, sizeof m->bodies[place].angular_velocity);
}

bool motion_place_pose(const duet_motion *m, duet_pose *pose, cl_int4 *cell)
{
    duet_large_pose p = {.pose = *pose};
    double at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = m->def.origin[k] + (double)pose->centre[k];
    bool ok = origin_place(&p, at, m->def.origin_edge);
    *pose = p.pose;
    memcpy(cell->s, p.cell, m->def.dims * sizeof *p.cell);
    return ok;
}

bool motion_placed_settle(const duet_motion *m, motion_placed *p, const char *call, duet_error *err)
{
    if (!m->cells)
        return true;
    p->cells = calloc((size_t)p->n + 1, sizeof *p->cells);
    if (!p->cells)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u cells", call, p->n);
    for (uint32_t i = 0; i < p->n; ++i)
        if (!motion_place_pose(m, &p->poses[i], &p->cells[i]))
            return error_set(err, DUET_STATUS_BAD_OBJECT,
                             "%s: body %u of %u is beyond 2^30 origin cells of edge %g", call, i,
                             p->n, (double)m->def.origin_edge);
    return true;
}

void motion_placed_keep(duet_motion *m, const motion_placed *p)
{
    for (uint32_t i = 0; i < p->n; ++i) {
        m->poses[p->places[i]] = p->poses[i];
        if (p->cells)
            m->cells[p->places[i]] = p->cells[i];
    }
}

static bool put_poses(duet_motion *m, const motion_placed *p, duet_error *err)
{
    if (!motion_forget_targets(m, p->places, p->n, err))
        return false;
    motion_placed_keep(m, p);
    return motion_send_places(m, p->places, p->n, PART_POSE | PART_SIZE, err) &&
           motion_wake_places(m, p->places, p->n, err);
}

bool duet_motion_set_poses(duet_motion *m, duet_body_list list, const duet_pose *poses,
                           duet_error *err)
{
    PUBLIC_CALL(err);
    motion_placed p;
    if (list.n > 0 && !error_given(poses, __func__, "poses", err))
        return false;
    bool ok = motion_placed_open(&p, m, list, false, __func__, err);
    if (ok && list.n > 0)
        memcpy(p.poses, poses, list.n * sizeof *poses);
    ok = ok && motion_placed_check(m, &p, PART_POSE, __func__, err) &&
         motion_placed_settle(m, &p, __func__, err) && motion_placed_admit(m, &p, __func__, err) &&
         motion_keep_whole(m, put_poses(m, &p, err));
    if (ok)
        motion_note(m, RECORDED_POSES, p.places, list.n, poses);
    motion_placed_close(&p);
    return ok;
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

// A pose with a target's place and rotation; z of both only in 3D.
static duet_pose aimed(const duet_motion *m, duet_pose pose, const duet_transform *target)
{
    bool solid = m->def.dims == 3;
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = k < (int)m->def.dims ? target->centre[k] : 0.0f;
    for (int k = 0; k < 4; ++k)
        pose.rotation[k] = solid || k >= 2 ? target->rotation[k] : 0.0f;
    return pose;
}

// What the state's bodies need to get to their targets in a step.
static bool find_velocities(duet_motion *m, const motion_placed *p, duet_error *err)
{
    duet_state *states = motion_read_states(m, err);
    for (uint32_t i = 0; states && i < p->n; ++i) {
        const duet_state *s = &states[p->places[i]];
        const float *q = p->poses[i].rotation;
        const double to[4] = {q[0], q[1], q[2], q[3]};
        for (uint32_t k = 0; k < m->def.dims; ++k) {
            double base =
                p->cells ? (double)p->cells[i].s[k] * (double)m->def.origin_edge : m->def.origin[k];
            p->bodies[i].velocity[k] =
                (float)((base + (double)p->poses[i].centre[k] - s->centre[k]) / m->def.dt);
        }
        turn_between(s->rotation, to, m->def.dt, p->bodies[i].angular_velocity);
    }
    free(states);
    return states;
}

static bool check_kinematic(const duet_motion *m, const motion_placed *p, const char *call,
                            duet_error *err)
{
    if (m->def.dt == 0.0)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: dt is 0; expected steps that take a time", call);
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->bodies[i].mass > 0.0f)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: body %u of %u has a mass of %g; expected one of mass 0", call, i,
                             p->n, (double)p->bodies[i].mass);
    return true;
}

// A pose may be too far away for a step.
static bool check_velocities(const motion_placed *p, const char *call, duet_error *err)
{
    for (uint32_t i = 0; i < p->n; ++i) {
        const char *fault = motion_body_fault(&p->bodies[i]);
        if (fault)
            return error_set(err, DUET_STATUS_BAD_OBJECT, "%s: body %u of %u: to get there, %s",
                             call, i, p->n, fault);
    }
    return true;
}

static bool aim(duet_motion *m, const motion_placed *p, const duet_transform *targets,
                duet_error *err)
{
    motion_commands *c = m->commands;
    motion_target *more = realloc(c->targets, ((size_t)c->n_targets + p->n + 1) * sizeof *more);
    if (!more)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u targets", p->n);
    c->targets = more;
    for (uint32_t i = 0; i < p->n; ++i) {
        c->targets[c->n_targets++] = (motion_target){p->places[i], targets[i]};
        m->bodies[p->places[i]] = p->bodies[i];
    }
    return motion_send_places(m, p->places, p->n, PART_VELOCITY | PART_ANGULAR_VELOCITY, err) &&
           motion_wake_places(m, p->places, p->n, err);
}

bool duet_motion_set_targets(duet_motion *m, duet_body_list list, const duet_transform *targets,
                             duet_error *err)
{
    PUBLIC_CALL(err);
    motion_placed p;
    if (list.n > 0 && !error_given(targets, __func__, "targets", err))
        return false;
    bool ok = motion_placed_open(&p, m, list, true, __func__, err);
    for (uint32_t i = 0; ok && i < list.n; ++i)
        p.poses[i] = aimed(m, p.poses[i], &targets[i]);
    ok = ok && check_kinematic(m, &p, __func__, err) &&
         motion_placed_check(m, &p, PART_POSE, __func__, err) &&
         motion_placed_settle(m, &p, __func__, err) && find_velocities(m, &p, err) &&
         check_velocities(&p, __func__, err) && motion_placed_admit(m, &p, __func__, err) &&
         motion_keep_whole(m, aim(m, &p, targets, err));
    if (ok)
        motion_note(m, RECORDED_TARGETS, p.places, list.n, targets);
    motion_placed_close(&p);
    return ok;
}

bool motion_forget_targets(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_commands *c = m->commands;
    if (c->n_targets == 0)
        return true;
    uint8_t *named = calloc((size_t)m->n + 1, 1);
    uint32_t *stopped = malloc((size_t)c->n_targets * sizeof *stopped);
    uint32_t n_kept = 0, n_stopped = 0;
    bool ok = named && stopped;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u places", m->n);
    for (uint32_t i = 0; ok && i < n; ++i)
        named[places[i]] = 1;
    for (uint32_t i = 0; ok && i < c->n_targets; ++i) {
        if (named[c->targets[i].place])
            stopped[n_stopped++] = c->targets[i].place;
        else
            c->targets[n_kept++] = c->targets[i];
    }
    for (uint32_t i = 0; i < n_stopped; ++i)
        motion_stop(m, stopped[i]);
    if (ok) {
        c->n_targets = n_kept;
        ok = motion_keep_whole(m, motion_send_places(m, stopped, n_stopped,
                                                     PART_VELOCITY | PART_ANGULAR_VELOCITY, err));
    }
    free(stopped);
    free(named);
    return ok;
}

bool motion_arrive(duet_motion *m, duet_error *err)
{
    motion_commands *c = m->commands;
    size_t n = c->n_targets;
    if (n == 0)
        return true;
    motion_placed p = {.n = c->n_targets,
                       .places = malloc(n * sizeof *p.places + 1),
                       .poses = malloc(n * sizeof *p.poses + 1)};
    bool ok = p.places && p.poses;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u targets", p.n);
    for (uint32_t i = 0; ok && i < n; ++i) {
        p.places[i] = c->targets[i].place;
        p.poses[i] = aimed(m, m->poses[p.places[i]], &c->targets[i].pose);
        motion_stop(m, p.places[i]);
    }
    ok = ok && motion_placed_settle(m, &p, __func__, err);
    if (ok)
        motion_placed_keep(m, &p);
    ok = ok && motion_send_places(m, p.places, p.n,
                                  PART_POSE | PART_VELOCITY | PART_ANGULAR_VELOCITY, err);
    // What it reaches there has not felt it yet.
    ok = ok && motion_wake_places(m, p.places, p.n, err);
    c->n_targets = 0;
    motion_placed_close(&p);
    return ok;
}
