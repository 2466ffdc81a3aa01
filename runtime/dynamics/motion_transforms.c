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

bool motion_place_poses(const duet_motion *m, duet_pose *poses, uint32_t n, cl_int4 **cells,
                        const char *call, duet_error *err)
{
    *cells = NULL;
    if (!m->cells)
        return true;
    *cells = calloc((size_t)n + 1, sizeof **cells);
    if (!*cells)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u cells", call, n);
    for (uint32_t i = 0; i < n; ++i) {
        duet_large_pose p = {.pose = poses[i]};
        double at[3];
        for (int k = 0; k < 3; ++k)
            at[k] = m->def.origin[k] + (double)poses[i].centre[k];
        if (!origin_place(&p, at, m->def.origin_edge))
            return error_set(err, DUET_STATUS_BAD_OBJECT,
                             "%s: body %u of %u is beyond 2^30 origin cells of edge %g", call, i, n,
                             (double)m->def.origin_edge);
        poses[i] = p.pose;
        for (uint32_t k = 0; k < m->def.dims; ++k)
            (*cells)[i].s[k] = p.cell[k];
    }
    return true;
}

// Says new ones of some places, to be sent; cells NULL without.
static void keep_poses(duet_motion *m, const uint32_t *places, const duet_pose *poses,
                       const cl_int4 *cells, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i) {
        m->poses[places[i]] = poses[i];
        if (cells)
            m->cells[places[i]] = cells[i];
    }
}

static bool put_poses(duet_motion *m, const uint32_t *places, const duet_pose *poses,
                      const cl_int4 *cells, uint32_t n, duet_error *err)
{
    if (!motion_forget_targets(m, places, n, err))
        return false;
    keep_poses(m, places, poses, cells, n);
    return motion_send_places(m, places, n, PART_POSE | PART_SIZE, err) &&
           motion_wake_places(m, places, n, err);
}

static bool check_poses(const duet_motion *m, const duet_pose *poses, uint32_t n, const char *call,
                        duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i) {
        const char *fault = motion_pose_fault(&poses[i], m->def.dims);
        ok = !fault ||
             error_set(err, DUET_STATUS_BAD_OBJECT, "%s: body %u of %u: %s", call, i, n, fault);
    }
    return ok;
}

// Copies of what is at some places, to be changed.
typedef struct placed {
    uint32_t *places;
    duet_pose *poses;
    duet_body *bodies;
    cl_int4 *cells; // where the poses lie; NULL without origin cells
} placed;

static bool begin_placed(placed *p, duet_motion *m, duet_body_list list, bool enabled,
                         const char *call, duet_error *err)
{
    *p = (placed){.places = motion_places_of(m, list, enabled, call, err)};
    p->poses = p->places ? motion_poses_at(m, p->places, list.n, err) : NULL;
    p->bodies = p->poses ? motion_bodies_at(m, p->places, list.n, err) : NULL;
    return p->bodies;
}

static void end_placed(placed *p)
{
    free(p->cells);
    free(p->bodies);
    free(p->poses);
    free(p->places);
}

bool duet_motion_set_poses(duet_motion *m, duet_body_list list, const duet_pose *poses,
                           duet_error *err)
{
    placed p;
    if (list.n > 0 && !error_given(poses, __func__, "poses", err))
        return false;
    bool ok = begin_placed(&p, m, list, false, __func__, err);
    if (ok && list.n > 0)
        memcpy(p.poses, poses, list.n * sizeof *poses);
    ok = ok && check_poses(m, p.poses, list.n, __func__, err) &&
         motion_place_poses(m, p.poses, list.n, &p.cells, __func__, err) &&
         motion_admit(m, p.poses, p.bodies, list.n, __func__, err) &&
         motion_keep_whole(m, put_poses(m, p.places, p.poses, p.cells, list.n, err));
    if (ok)
        motion_note(m, RECORDED_POSES, p.places, list.n, poses);
    end_placed(&p);
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
static bool find_velocities(duet_motion *m, const uint32_t *places, const duet_pose *poses,
                            const cl_int4 *cells, uint32_t n, duet_body *bodies, duet_error *err)
{
    duet_state *states = motion_read_states(m, err);
    for (uint32_t i = 0; states && i < n; ++i) {
        const duet_state *s = &states[places[i]];
        const float *q = poses[i].rotation;
        const double to[4] = {q[0], q[1], q[2], q[3]};
        for (uint32_t k = 0; k < m->def.dims; ++k) {
            double base =
                cells ? (double)cells[i].s[k] * (double)m->def.origin_edge : m->def.origin[k];
            bodies[i].velocity[k] =
                (float)((base + (double)poses[i].centre[k] - s->centre[k]) / m->def.dt);
        }
        turn_between(s->rotation, to, m->def.dt, bodies[i].angular_velocity);
    }
    free(states);
    return states;
}

static bool check_kinematic(const duet_motion *m, const uint32_t *places, uint32_t n,
                            const char *call, duet_error *err)
{
    if (m->def.dt == 0.0)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: dt is 0; expected steps that take a time", call);
    for (uint32_t i = 0; i < n; ++i)
        if (m->bodies[places[i]].mass > 0.0f)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: body %u of %u has a mass of %g; expected one of mass 0", call, i,
                             n, (double)m->bodies[places[i]].mass);
    return true;
}

// A pose may be too far away for a step.
static bool check_velocities(const duet_body *bodies, uint32_t n, const char *call, duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i) {
        const char *fault = motion_body_fault(&bodies[i]);
        if (fault)
            return error_set(err, DUET_STATUS_BAD_OBJECT, "%s: body %u of %u: to get there, %s",
                             call, i, n, fault);
    }
    return true;
}

static bool aim(duet_motion *m, const uint32_t *places, const duet_transform *targets,
                const duet_body *bodies, uint32_t n, duet_error *err)
{
    motion_commands *c = m->commands;
    motion_target *more = realloc(c->targets, ((size_t)c->n_targets + n + 1) * sizeof *more);
    if (!more)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u targets", n);
    c->targets = more;
    for (uint32_t i = 0; i < n; ++i) {
        c->targets[c->n_targets++] = (motion_target){places[i], targets[i]};
        duet_body *b = &m->bodies[places[i]];
        memcpy(b->velocity, bodies[i].velocity, sizeof b->velocity);
        memcpy(b->angular_velocity, bodies[i].angular_velocity, sizeof b->angular_velocity);
    }
    return motion_send_places(m, places, n, PART_VELOCITY | PART_ANGULAR_VELOCITY, err) &&
           motion_wake_places(m, places, n, err);
}

bool duet_motion_set_targets(duet_motion *m, duet_body_list list, const duet_transform *targets,
                             duet_error *err)
{
    placed p;
    if (list.n > 0 && !error_given(targets, __func__, "targets", err))
        return false;
    bool ok = begin_placed(&p, m, list, true, __func__, err);
    for (uint32_t i = 0; ok && i < list.n; ++i)
        p.poses[i] = aimed(m, p.poses[i], &targets[i]);
    ok = ok && check_kinematic(m, p.places, list.n, __func__, err) &&
         check_poses(m, p.poses, list.n, __func__, err) &&
         motion_place_poses(m, p.poses, list.n, &p.cells, __func__, err) &&
         find_velocities(m, p.places, p.poses, p.cells, list.n, p.bodies, err) &&
         check_velocities(p.bodies, list.n, __func__, err) &&
         motion_admit(m, p.poses, p.bodies, list.n, __func__, err) &&
         motion_keep_whole(m, aim(m, p.places, targets, p.bodies, list.n, err));
    if (ok)
        motion_note(m, RECORDED_TARGETS, p.places, list.n, targets);
    end_placed(&p);
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
    uint32_t n = c->n_targets;
    uint32_t *places = malloc((size_t)n * sizeof *places + 1);
    duet_pose *poses = malloc((size_t)n * sizeof *poses + 1);
    cl_int4 *cells = NULL;
    bool ok = places && poses;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u targets", n);
    for (uint32_t i = 0; ok && i < n; ++i) {
        places[i] = c->targets[i].place;
        poses[i] = aimed(m, m->poses[places[i]], &c->targets[i].pose);
        motion_stop(m, places[i]);
    }
    ok = ok && motion_place_poses(m, poses, n, &cells, __func__, err);
    if (ok)
        keep_poses(m, places, poses, cells, n);
    ok = ok &&
         motion_send_places(m, places, n, PART_POSE | PART_VELOCITY | PART_ANGULAR_VELOCITY, err);
    // What it reaches there has not felt it yet.
    ok = ok && motion_wake_places(m, places, n, err);
    c->n_targets = 0;
    free(cells);
    free(poses);
    free(places);
    return ok;
}
