// SPDX-License-Identifier: MIT
// What is set, pushed or aimed at while a motion runs.
#include "runtime/dynamics/motion_commands.h"

#include "base/error.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/narrowphase/origin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const field_names[] = {
    "velocity", "angular_velocity", "mass", "restitution", "friction", "filter", "fixed_rotation"};

enum { N_FIELDS = sizeof field_names / sizeof field_names[0] };

const char *duet_body_field_name(uint32_t field)
{
    for (int i = 0; i < N_FIELDS; ++i)
        if (field == 1u << i)
            return field_names[i];
    return NULL;
}

void motion_stop(duet_motion *m, uint32_t place)
{
    memset(m->bodies[place].velocity, 0, sizeof m->bodies[place].velocity);
    memset(m->bodies[place].angular_velocity, 0, sizeof m->bodies[place].angular_velocity);
}

bool motion_keep_whole(duet_motion *m, bool made)
{
    m->broken = m->broken || !made;
    return made;
}

// ---------------------------------------------------------------- effects

static bool lacks(uint32_t missing, const char *call, const char *what, duet_error *err)
{
    for (uint32_t i = 0; effect_at(i); ++i)
        if (missing & effect_at(i)->effect)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: %sneeds the effect %s; expected the motion's wants to ask for it",
                             call, what, effect_at(i)->name);
    return true;
}

bool motion_needs(const duet_motion *m, uint32_t effect, const char *call, duet_error *err)
{
    return lacks(effect & ~m->effects, call, "it ", err);
}

// What is known of the motion's objects and of some that join them. How fast those are is
// not looked at: continuous is called for by what a motion begins with.
static effect_facts joined(const duet_motion *m, const effect_facts *more)
{
    effect_facts f = m->facts;
    f.rotated |= more->rotated;
    f.moving |= more->moving;
    f.turning |= more->turning;
    f.massive |= more->massive;
    f.turnable |= more->turnable;
    f.uneven |= more->uneven;
    f.elastic |= more->elastic;
    f.rough |= more->rough;
    f.filtered |= more->filtered;
    return f;
}

static uint32_t missing_for(const duet_motion *m, const effect_facts *more)
{
    effect_facts f = joined(m, more);
    return effect_infer(&m->def, &f) & ~m->effects;
}

static bool tell_who_lacks(const duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                           uint32_t n, const char *call, duet_error *err)
{
    for (uint32_t i = 0; i < n; ++i) {
        effect_facts f = effect_facts_of(&m->def, &poses[i], &bodies[i], 1);
        char what[48];
        snprintf(what, sizeof what, "body %u of %u ", i, n);
        if (!lacks(missing_for(m, &f), call, what, err))
            return false;
    }
    return false;
}

bool motion_admit(duet_motion *m, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                  const char *call, duet_error *err)
{
    effect_facts more = effect_facts_of(&m->def, poses, bodies, n);
    if (missing_for(m, &more))
        return tell_who_lacks(m, poses, bodies, n, call, err);
    const effect_facts before = m->facts;
    m->facts = joined(m, &more);
    bool tumbles = motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY) && m->facts.uneven && !before.uneven;
    if (!tumbles || motion_prepare_again(m, err))
        return true;
    m->facts = before;
    return false;
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
}

static uint32_t parts_of(uint32_t fields)
{
    static const uint32_t parts[N_FIELDS] = {PART_VELOCITY, PART_ANGULAR_VELOCITY, PART_MASS,
                                             PART_SURFACE,  PART_SURFACE,          PART_FILTER,
                                             PART_MASS};
    uint32_t all = 0;
    for (int i = 0; i < N_FIELDS; ++i)
        all |= fields & 1u << i ? parts[i] : 0;
    return all;
}

static duet_pose *poses_at(const duet_motion *m, const uint32_t *places, uint32_t n,
                           duet_error *err)
{
    duet_pose *poses = malloc((size_t)n * sizeof *poses + 1);
    if (!poses)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u poses", n);
    for (uint32_t i = 0; poses && i < n; ++i)
        poses[i] = m->poses[places[i]];
    return poses;
}

// Contacts of one colour share no body that moves; those of a body that has a mass from now
// on may have done so.
static bool uncolour(duet_motion *m, const uint8_t *gained, duet_error *err)
{
    motion_rows links, colours;
    if (m->n_contacts == 0 || !motion_has(m, DUET_EFFECT_CONTACT_RESPONSE))
        return true;
    if (!motion_rows_open(m, LINKS, 0, m->n_contacts, 2, false, &links, err))
        return false;
    if (!motion_rows_open(m, COLOUR_OF, 0, m->n_contacts, 1, false, &colours, err)) {
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
static bool change_masses(duet_motion *m, const uint32_t *places, const duet_body *bodies,
                          uint32_t n, duet_error *err)
{
    uint8_t *gained = calloc((size_t)m->n + 1, 1);
    bool any = false;
    if (!gained)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u places", m->n);
    for (uint32_t i = 0; i < n; ++i) {
        bool had = m->bodies[places[i]].mass > 0.0f, has = bodies[i].mass > 0.0f;
        m->rows_stale |= had != has;
        gained[places[i]] |= has && !had;
        any |= has && !had;
    }
    bool ok = !any || uncolour(m, gained, err);
    free(gained);
    return ok;
}

static bool set_fields(duet_motion *m, const uint32_t *places, const duet_body *bodies, uint32_t n,
                       uint32_t fields, duet_error *err)
{
    const uint32_t moving = DUET_BODY_VELOCITY | DUET_BODY_ANGULAR_VELOCITY | DUET_BODY_MASS;
    if ((fields & moving) && !motion_forget_targets(m, places, n, err))
        return false;
    if ((fields & DUET_BODY_MASS) && !change_masses(m, places, bodies, n, err))
        return false;
    m->rows_stale |= (fields & DUET_BODY_FILTER) != 0;
    for (uint32_t i = 0; i < n; ++i)
        copy_fields(&m->bodies[places[i]], &bodies[i], fields);
    return motion_send_places(m, places, n, parts_of(fields), err) &&
           motion_wake_places(m, places, n, err);
}

// What the bodies will be.
static duet_body *merge_fields(const duet_motion *m, const uint32_t *places, duet_body_list list,
                               uint32_t fields, const duet_body *bodies, const char *call,
                               duet_error *err)
{
    duet_body *merged = malloc((size_t)list.n * sizeof *merged + 1);
    bool ok = merged ||
              error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u bodies", call, list.n);
    for (uint32_t i = 0; ok && i < list.n; ++i) {
        merged[i] = m->bodies[places[i]];
        copy_fields(&merged[i], &bodies[i], fields);
        const char *fault = motion_body_fault(&merged[i]);
        ok = !fault || error_set(err, DUET_STATUS_BAD_OBJECT, "%s: body %u of %u: %s", call, i,
                                 list.n, fault);
    }
    if (ok)
        return merged;
    free(merged);
    return NULL;
}

bool duet_motion_set_bodies(duet_motion *m, duet_body_list list, uint32_t fields,
                            const duet_body *bodies, duet_error *err)
{
    if (fields & ~(uint32_t)DUET_BODY_ALL)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: fields is %#x; expected bits of "
                         "duet_body_field",
                         __func__, fields);
    if (list.n > 0 && !error_given(bodies, __func__, "bodies", err))
        return false;
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    duet_body *merged =
        places ? merge_fields(m, places, list, fields, bodies, __func__, err) : NULL;
    duet_pose *poses = merged ? poses_at(m, places, list.n, err) : NULL;
    bool ok = poses && motion_admit(m, poses, merged, list.n, __func__, err) &&
              motion_keep_whole(m, set_fields(m, places, merged, list.n, fields, err));
    free(poses);
    free(merged);
    free(places);
    return ok;
}

// ---------------------------------------------------------------- poses

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

static duet_body *bodies_at(const duet_motion *m, const uint32_t *places, uint32_t n,
                            duet_error *err)
{
    duet_body *bodies = malloc((size_t)n * sizeof *bodies + 1);
    if (!bodies)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bodies", n);
    for (uint32_t i = 0; bodies && i < n; ++i)
        bodies[i] = m->bodies[places[i]];
    return bodies;
}

bool duet_motion_set_poses(duet_motion *m, duet_body_list list, const duet_pose *poses,
                           duet_error *err)
{
    if (list.n > 0 && !error_given(poses, __func__, "poses", err))
        return false;
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    duet_pose *copy = places ? poses_at(m, places, list.n, err) : NULL;
    duet_body *bodies = copy ? bodies_at(m, places, list.n, err) : NULL;
    cl_int4 *cells = NULL;
    if (bodies && list.n > 0)
        memcpy(copy, poses, list.n * sizeof *copy);
    bool ok = bodies && check_poses(m, copy, list.n, __func__, err) &&
              motion_place_poses(m, copy, list.n, &cells, __func__, err) &&
              motion_admit(m, copy, bodies, list.n, __func__, err) &&
              motion_keep_whole(m, put_poses(m, places, copy, cells, list.n, err));
    free(cells);
    free(bodies);
    free(copy);
    free(places);
    return ok;
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
    m->rows_stale = true; // walls are elsewhere
    return motion_wake_all(m, err);
}

bool duet_motion_set_def(duet_motion *m, const duet_motion_def *def, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !motion_check_def(def, err) ||
        !check_same(def, &m->def, __func__, err))
        return false;
    if (def->pair != m->def.pair)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: pair is another; expected the motion's, which cannot change",
                         __func__);
    return lacks(effect_infer(def, &m->facts) & ~m->effects, __func__, "it ", err) &&
           timeline_finish(&m->times, err) && motion_begin_commands(m, err) &&
           motion_keep_whole(m, change_world(m, def, err));
}

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

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

// v turned by q of length 1, or back.
static void turn(const double q[4], bool back, const double v[3], double to[3])
{
    double sign = back ? -1.0 : 1.0;
    const double u[3] = {sign * q[0], sign * q[1], sign * q[2]};
    double t[3], s[3];
    cross(u, v, t);
    for (int k = 0; k < 3; ++k)
        t[k] *= 2.0;
    cross(u, t, s);
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
    cross(anchor, force, torque);
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

// ---------------------------------------------------------------- targets

static double dot(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k)
        sum += a[k] * b[k];
    return sum;
}

// The steady angular velocity that turns `from` into `to` in the time.
static void turn_between(const double from[4], const double to[4], double time, float velocity[3])
{
    const double norm = sqrt(dot(to, to, 4) * dot(from, from, 4));
    double v[3], across[3], w = dot(to, from, 4) / norm;
    cross(from, to, across);
    for (int k = 0; k < 3; ++k) // to * conjugate(from)
        v[k] = (from[3] * to[k] - to[3] * from[k] + across[k]) / norm;
    double sine = sqrt(dot(v, v, 3));
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
    duet_state *states = malloc((size_t)m->n * sizeof *states + 1);
    if (!states)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u states", m->n);
    bool ok = duet_motion_get_states(m, states, err);
    for (uint32_t i = 0; ok && i < n; ++i) {
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
    return ok;
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
        copy_fields(&m->bodies[places[i]], &bodies[i],
                    DUET_BODY_VELOCITY | DUET_BODY_ANGULAR_VELOCITY);
    }
    return motion_send_places(m, places, n, PART_VELOCITY | PART_ANGULAR_VELOCITY, err) &&
           motion_wake_places(m, places, n, err);
}

bool duet_motion_set_targets(duet_motion *m, duet_body_list list, const duet_transform *targets,
                             duet_error *err)
{
    if (list.n > 0 && !error_given(targets, __func__, "targets", err))
        return false;
    uint32_t *places = motion_places_of(m, list, true, __func__, err);
    duet_pose *poses = places ? poses_at(m, places, list.n, err) : NULL;
    duet_body *bodies = poses ? bodies_at(m, places, list.n, err) : NULL;
    cl_int4 *cells = NULL;
    for (uint32_t i = 0; bodies && i < list.n; ++i)
        poses[i] = aimed(m, poses[i], &targets[i]);
    bool ok = bodies && check_kinematic(m, places, list.n, __func__, err) &&
              check_poses(m, poses, list.n, __func__, err) &&
              motion_place_poses(m, poses, list.n, &cells, __func__, err) &&
              find_velocities(m, places, poses, cells, list.n, bodies, err) &&
              motion_admit(m, poses, bodies, list.n, __func__, err) &&
              motion_keep_whole(m, aim(m, places, targets, bodies, list.n, err));
    free(cells);
    free(bodies);
    free(poses);
    free(places);
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

// ---------------------------------------------------------------- after a step

static bool arrive(duet_motion *m, duet_error *err)
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

static bool forget_forces(duet_motion *m, duet_error *err)
{
    m->commands->pushed = false;
    return timeline_fill(&m->times, "clear", &m->buffers[FORCES], 0, 0, (size_t)m->n * 8, err);
}

static void empty_places(duet_motion *m)
{
    motion_commands *c = m->commands;
    c->any_left = false;
    for (uint32_t place = m->n; place-- > 0;) {
        if (c->states[place] != PLACE_LEFT)
            continue;
        c->states[place] = PLACE_EMPTY;
        c->first_empty = place < c->first_empty ? place : c->first_empty;
    }
}

bool motion_end_commands(duet_motion *m, duet_error *err)
{
    motion_commands *c = m->commands;
    if (c->any_left && (!m->rows_stale || !motion_has(m, DUET_EFFECT_CONTACT)))
        empty_places(m);
    return (c->n_targets == 0 || arrive(m, err)) && (!c->pushed || forget_forces(m, err));
}
