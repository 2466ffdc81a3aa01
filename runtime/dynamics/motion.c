// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/recording.h"
#include "runtime/dynamics/vector.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7003 };

// A slop is this part of the objects' mean least extent.
static const double slop_of_extent = 0.005;

duet_body duet_default_body(void)
{
    return (duet_body){.mass = 1.0f, .group = UINT32_MAX, .mask = UINT32_MAX};
}

duet_motion_def duet_default_motion_def(void)
{
    return (duet_motion_def){
        .plan = duet_default_plan(NULL),
        .dims = 3,
        .dt = 1.0 / 60.0,
        .substeps = 4,
        .max_push_speed = 3.0,
        .restitution_threshold = 1.0,
        .sleep_speed = 0.05,
        .sleep_after = 0.5,
        .event_mask = UINT32_MAX,
        .cookie = COOKIE,
    };
}

// ---------------------------------------------------------------- checks

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
            return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s is %g; expected %s",
                             numbers[i].name, numbers[i].value, numbers[i].right);
    for (int k = 0; k < 3; ++k)
        if (!isfinite(def->gravity[k]) || !isfinite(def->centre[k]) || !isfinite(def->origin[k]))
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%c of gravity, centre or origin is not a finite number", "xyz"[k]);
    return true;
}

static bool check_edge(const duet_motion_def *def, duet_error *err)
{
    for (uint32_t k = 0; def->boundary != DUET_BOUNDARY_NONE && k < def->dims; ++k)
        if (!isfinite(def->lower[k]) || !isfinite(def->upper[k]) || def->lower[k] >= def->upper[k])
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "the walls across %c are at %g and %g; expected finite and "
                             "rising",
                             "xyz"[k], def -> lower[k], def -> upper[k]);
    return true;
}

// What origin cells do not go with.
static bool check_origin(const duet_motion_def *def, duet_error *err)
{
    if (!origin_is_edge(def->origin_edge))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "origin_edge is %g; expected 0, or a power of two from 2^-100 to "
                         "2^100",
                         (double)def->origin_edge);
    if (def->origin_edge == 0.0f)
        return true;
    if (def->doubles)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "origin cells are for a state in float; expected doubles = false");
    return (def->boundary == DUET_BOUNDARY_NONE && def->attraction == 0.0) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "walls, a periodic world and an attraction know no origin cells; expected "
                     "doubles, and no origin cells");
}

bool motion_check_def(const duet_motion_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the motion's def does not come from duet_default_motion_def");
    if (!def->pair)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "the motion's def has no device pair");
    if (def->dims != 2 && def->dims != 3)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "dims is %u; expected 2 or 3", def->dims);
    if (def->substeps < 1 || def->substeps > 1000)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "substeps is %u; expected 1 to 1000",
                         def->substeps);
    if (def->integrator > DUET_INTEGRATOR_YOSHIDA)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "integrator is %d; expected a duet_integrator", (int)def->integrator);
    if (def->boundary > DUET_BOUNDARY_PERIODIC)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "boundary is %d; expected a duet_boundary",
                         (int)def->boundary);
    if (def->doubles && !def->pair->devices[1].info.fp64)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s has no double; expected doubles = false",
                         def->pair->devices[1].info.selector);
    return check_numbers(def, err) && check_edge(def, err) && check_origin(def, err);
}

// Effects that cannot be had together.
static bool check_effects(const duet_motion *m, duet_error *err)
{
    bool contact = m->effects & DUET_EFFECT_CONTACT;
    if (contact && m->def.boundary == DUET_BOUNDARY_PERIODIC)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "contacts are not found across the seam of a periodic world; expected "
                         "walls, or no contact");
    if ((m->effects & DUET_EFFECT_CONTACT_RESPONSE) && m->def.integrator != DUET_INTEGRATOR_EULER)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "contacts are solved with the integrator euler; expected that, or "
                         "no response");
    return true;
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

const char *motion_body_fault(const duet_body *b)
{
    if (!vector_is_finite(b->velocity, 3) || !vector_is_finite(b->angular_velocity, 3))
        return "a velocity or angular velocity is not finite";
    if (!is_between(b->mass, 0.0, 1e30) || (b->mass > 0.0f && b->mass < 1e-30f))
        return "the mass must be 0, or from 1e-30 to 1e30";
    if (!is_between(b->restitution, 0.0, 1.0))
        return "the restitution must be from 0 to 1";
    if (!is_between(b->radius, 0.0, FLT_MAX))
        return "the radius must be 0 or above";
    return is_between(b->friction, 0.0, 1e6) ? NULL : "the friction must be from 0 to 1e6";
}

static bool check_objects(const duet_motion *m, duet_error *err)
{
    for (uint32_t id = 0; id < m->n; ++id) {
        const char *fault = motion_pose_fault(&m->poses[id], m->def.dims);
        if (!fault)
            fault = motion_body_fault(&m->bodies[id]);
        if (fault)
            return error_set(err, DUET_STATUS_BAD_OBJECT, "object %u of %u: %s", id, m->n, fault);
    }
    return true;
}

// ---------------------------------------------------------------- owner

// Of what can push.
static double mean_least_extent(const duet_motion *m)
{
    double sum = 0.0;
    uint32_t n = 0;
    for (uint32_t id = 0; id < m->n; ++id) {
        if (m->bodies[id].sensor)
            continue;
        ++n;
        const float *h = m->poses[id].half_extents;
        double least = fmin(h[0], h[1]);
        sum += 2.0 * ((m->def.dims == 3 ? fmin(least, h[2]) : least) + m->bodies[id].radius);
    }
    return n > 0 ? sum / n : 0.0;
}

static bool settle_pose(const duet_motion *m, duet_large_pose p, duet_pose *pose, cl_int4 *cell)
{
    bool ok = origin_settle(&p, m->def.origin_edge);
    *pose = p.pose;
    memcpy(cell->s, p.cell, m->def.dims * sizeof *p.cell);
    return ok;
}

// Each centre into its origin cell: those of poses count from def.origin.
static bool place_objects(duet_motion *m, const duet_large_pose *large_poses, duet_error *err)
{
    if (m->def.origin_edge == 0.0f)
        return true;
    m->cells = calloc((size_t)m->n + 1, sizeof *m->cells);
    if (!m->cells)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for the cells of %u objects", m->n);
    for (uint32_t id = 0; id < m->n; ++id)
        if (!(large_poses ? settle_pose(m, large_poses[id], &m->poses[id], &m->cells[id])
                          : motion_place_pose(m, &m->poses[id], &m->cells[id])))
            return error_set(err, DUET_STATUS_BAD_OBJECT,
                             "object %u of %u is beyond 2^30 origin cells of edge %g", id, m->n,
                             (double)m->def.origin_edge);
    return true;
}

static bool copy_objects(duet_motion *m, const duet_pose *poses, const duet_large_pose *large_poses,
                         const duet_body *bodies, uint32_t n, duet_error *err)
{
    m->n = n;
    m->poses = calloc((size_t)n + 1, sizeof *m->poses);
    m->bodies = calloc((size_t)n + 1, sizeof *m->bodies);
    if (!m->poses || !m->bodies)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u objects that move", n);
    for (uint32_t id = 0; id < n; ++id)
        m->poses[id] = large_poses ? large_poses[id].pose : poses[id];
    if (n > 0 && bodies)
        memcpy(m->bodies, bodies, n * sizeof *bodies);
    for (uint32_t id = 0; id < n && !bodies; ++id)
        m->bodies[id] = duet_default_body();
    return check_objects(m, err) && place_objects(m, large_poses, err);
}

// Pairs are looked for among bounds, which the grid may place as it likes.
static bool open_world(duet_motion *m, duet_error *err)
{
    if (!(m->effects & DUET_EFFECT_CONTACT))
        return true;
    duet_world_def def = duet_default_world_def();
    def.stage_times = m->def.stage_times;
    def.pair = m->def.pair;
    def.plan = m->def.plan;
    def.dims = m->def.dims;
    def.shape = DUET_SHAPE_BOUNDS;
    m->world = duet_world_create(&def, err);
    return m->world;
}

static bool open_device(duet_motion *m, duet_error *err)
{
    m->device = &m->def.pair->devices[1];
    timeline_begin(&m->times, m->device, false);
    m->gen = gen_open(m->def.pair->kernel_dir, err);
    m->programs = m->gen ? program_set_open(m->device, m->gen, &m->def.pair->builder, err) : NULL;
    return m->programs;
}

static bool open_motion(duet_motion *m, const duet_pose *poses, const duet_large_pose *large_poses,
                        const duet_body *bodies, uint32_t n, duet_error *err)
{
    if (!copy_objects(m, poses, large_poses, bodies, n, err))
        return false;
    effect_facts_add(&m->facts, &m->def, m->poses, m->bodies, n);
    m->effects = effect_infer(&m->def, &m->facts);
    double slop = m->def.slop > 0.0 ? m->def.slop : slop_of_extent * mean_least_extent(m);
    m->margin = MOTION_SLOPS * slop;
    return check_effects(m, err) && open_world(m, err) && open_device(m, err) &&
           motion_prepare(m, err) && motion_reset(m, err);
}

static bool check_count(const duet_pose *poses, uint32_t n, duet_error *err)
{
    if (n > MOTION_MOST)
        return error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a motion holds at most %u", n,
                         MOTION_MOST);
    return n == 0 || error_given(poses, "duet_motion_create", "poses", err);
}

duet_motion *motion_create(const duet_motion_def *def, const duet_pose *poses,
                           const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                           duet_error *err)
{
    if (!motion_check_def(def, err) || !check_count(poses, n, err))
        return NULL;
    duet_motion *m = calloc(1, sizeof *m);
    if (!m) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a motion");
        return NULL;
    }
    m->def = *def;
    device_pair_hold(def->pair);
    if (!open_motion(m, poses, large_poses, bodies, n, err)) {
        duet_motion_destroy(m);
        return NULL;
    }
    return m;
}

duet_motion *duet_motion_create(const duet_motion_def *def, const duet_pose *poses,
                                const duet_body *bodies, uint32_t n, duet_error *err)
{
    return motion_create(def, poses, NULL, bodies, n, err);
}

void duet_motion_destroy(duet_motion *m)
{
    if (!m)
        return;
    background_close(&m->background);
    timeline_clear(&m->times);
    motion_forget_maps(m);
    for (int i = 0; i < MOTION_BUFFERS; ++i)
        buffer_release(&m->buffers[i]);
    scan_close(&m->scan);
    radix_sort_close(&m->radix);
    duet_world_destroy(m->world);
    program_set_close(m->programs);
    gen_close(m->gen);
    free(m->poses);
    free(m->cells);
    free(m->bodies);
    motion_free_events(&m->told);
    motion_forget_moved(&m->reading);
    motion_forget_commands(m->commands);
    motion_forget_recording(m);
    duet_device_pair_destroy(m->def.pair);
    free(m);
}

const duet_plan *duet_motion_get_plan(const duet_motion *m)
{
    return m && m->world && !m->background.under_way ? duet_world_get_plan(m->world) : NULL;
}

uint32_t duet_motion_get_effects(const duet_motion *m)
{
    return m ? m->effects : 0;
}

uint32_t duet_motion_get_count(const duet_motion *m)
{
    return m ? m->n : 0;
}

uint64_t duet_motion_get_step(const duet_motion *m)
{
    return m ? m->step : 0;
}
