// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_create.h"

#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_state.h"
#include "runtime/dynamics/substeps.h"

#include "base/error.h"
#include "base/exact_sum.h"
#include "runtime/bodies/ground_def.h"
#include "runtime/broadphase/world.h"
#include "runtime/narrowphase/origin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A slop is this part of the objects' mean least extent.
static const double slop_of_extent = 0.005;

// ---------------------------------------------------------------- checks

// Effects that cannot be had together.
static bool check_effects(const duet_motion *m, duet_error *err)
{
    bool contact = m->effects & DUET_EFFECT_CONTACT;
    if (contact && m->def.boundary == DUET_BOUNDARY_PERIODIC)
        return bad_argument(err, "contacts are not found across the seam of a periodic world; "
                                 "expected walls, or no contact");
    if ((m->effects & DUET_EFFECT_CONTACT_RESPONSE) && m->def.integrator != DUET_INTEGRATOR_EULER)
        return bad_argument(
            err, "contacts are solved with the integrator euler; expected that, or no response");
    return true;
}

static bool check_objects(const duet_motion *m, duet_error *err)
{
    for (uint32_t id = 0; id < m->n; ++id) {
        const char *fault = motion_pose_fault(&m->poses[id], m->def.dims);
        if (!fault)
            fault = motion_body_fault(&m->def, &m->bodies[id]);
        if (fault)
            return error_set(err, DUET_STATUS_BAD_OBJECT, "object %u of %u: %s", id, m->n, fault);
    }
    return true;
}

// ---------------------------------------------------------------- owner

// Averages over bodies that can push; the same bits in any order of them.
static double mean_least_extent(const duet_motion *m)
{
    exact_sum sum = {0};
    uint32_t n = 0;
    for (uint32_t id = 0; id < m->n; ++id) {
        if (m->bodies[id].sensor)
            continue;
        ++n;
        const float *h = m->poses[id].half_extents;
        double least = fmin(h[0], h[1]);
        least = m->def.dims == 3 ? fmin(least, h[2]) : least;
        exact_sum_add(&sum, 2.0 * (least + m->bodies[id].radius));
    }
    return n > 0 ? exact_sum_round(&sum) / n : 0.0;
}

static bool settle_pose(const duet_motion *m, duet_large_pose p, duet_pose *pose, cl_int4 *cell)
{
    bool ok = origin_settle(&p, m->def.origin_edge);
    *pose = p.pose;
    memcpy(cell->s, p.cell, m->def.dims * sizeof *p.cell);
    return ok;
}

// Each centre into its origin cell: the centres of poses count from def.origin.
static bool place_objects(duet_motion *m, const duet_large_pose *large_poses, duet_error *err)
{
    if (m->def.origin_edge == 0.0f)
        return true;
    m->cells = calloc((size_t)m->n + 1, sizeof *m->cells);
    if (!m->cells)
        return no_memory(err, "the cells of %u objects", m->n);
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
        return no_memory(err, "%u objects that move", n);
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
    def.plan = m->plan.search;
    def.dims = m->def.dims;
    def.shape = DUET_SHAPE_BOUNDS;
    m->graph.world = duet_world_create(&def, err);
    return m->graph.world &&
           world_expect_motion(m->graph.world, m->def.boundary == DUET_BOUNDARY_NONE, err);
}

static bool open_device(duet_motion *m, duet_error *err)
{
    m->device = &m->def.pair->devices[1];
    timeline_begin(&m->times, m->device, false);
    m->gen = gen_open(m->def.pair->kernel_dir, err);
    m->programs = m->gen ? program_set_open(m->device, m->gen, &m->def.pair->builder, err) : NULL;
    return m->programs;
}

static void know_objects(duet_motion *m)
{
    effect_facts_add(&m->facts, &m->def, m->poses, m->bodies, m->n);
    m->extent = mean_least_extent(m);
}

// Sets all that follows from the facts, whatever objects there are.
static void infer(duet_motion *m)
{
    double slop = m->def.slop > 0.0 ? m->def.slop : slop_of_extent * m->extent;
    m->effects = effect_infer(&m->def, m->facts);
    m->products = products_of_saved(false);
    m->margin = MOTION_SLOPS * slop;
}

bool motion_open(duet_motion *m, duet_error *err)
{
    bool ok =
        open_device(m, err) && motion_plan_read(&m->plan, &m->def.plan, &m->device->info, err) &&
        open_world(m, err) &&
        (!(m->effects & DUET_EFFECT_GROUND) || ground_send(&m->ground, m->device, err)) &&
        motion_prepare(m, err) &&
        (!(m->effects & DUET_EFFECT_SKIN) || motion_build_ahead(m, COMPUTE_ALTERED_AABBS, err)) &&
        motion_reset(m, err);
    if (ok)
        motion_plan_note(m);
    return ok;
}

static bool check_count(const duet_pose *poses, uint32_t n, duet_error *err)
{
    if (n > MOTION_MOST)
        return error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a motion holds at most %u", n,
                         MOTION_MOST);
    return n == 0 || error_given(poses, "duet_motion_create", "poses", err);
}

static duet_motion *keep_if(duet_motion *m, bool ok)
{
    if (ok)
        return m;
    duet_motion_destroy(m);
    return NULL;
}

static duet_motion *hold(const duet_motion_def *def, const duet_pose *poses,
                         const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                         duet_error *err)
{
    duet_motion *m = calloc(1, sizeof *m);
    if (!m)
        return null_no_memory(err, "a motion");
    m->def = *def;
    device_pair_hold(def->pair);
    return keep_if(m, ground_copy(&m->ground, &m->def, err) &&
                          copy_objects(m, poses, large_poses, bodies, n, err));
}

duet_motion *motion_know(const duet_motion_def *def, const duet_pose *poses,
                         const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                         duet_error *err)
{
    if (!motion_check_def(def, err) || !check_count(poses, n, err))
        return NULL;
    duet_motion *m = hold(def, poses, large_poses, bodies, n, err);
    if (!m)
        return NULL;
    know_objects(m);
    infer(m);
    return keep_if(m, ground_def_check_carrier(&m->def, m->bodies, n, err) &&
                          check_effects(m, err) && motion_choose_substeps(m, err));
}

duet_motion *motion_create(const duet_motion_def *def, const duet_pose *poses,
                           const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                           duet_error *err)
{
    duet_motion *m = motion_know(def, poses, large_poses, bodies, n, err);
    return m ? keep_if(m, motion_open(m, err)) : NULL;
}

duet_motion *domain_create(const duet_motion_def *def, const effect_facts *facts, double extent,
                           duet_error *err)
{
    duet_motion *m = hold(def, NULL, NULL, NULL, 0, err);
    if (!m)
        return NULL;
    m->is_domain = true;
    m->facts = *facts;
    m->extent = extent;
    infer(m);
    return keep_if(m, motion_open(m, err));
}

duet_motion *duet_motion_create(const duet_motion_def *def, const duet_pose *poses,
                                const duet_body *bodies, uint32_t n, duet_error *err)
{
    PUBLIC_CALL(err);
    return motion_create(def, poses, NULL, bodies, n, err);
}

void duet_motion_destroy(duet_motion *m)
{
    if (!m)
        return;
    background_close(&m->halves.thread);
    timeline_clear(&m->times);
    motion_forget_maps(m);
    for (int i = 0; i < MOTION_BUFFERS; ++i)
        buffer_release(&m->buffers[i]);
    host_block_release(&m->awake.counts);
    scan_close(&m->graph.scan);
    radix_sort_close(&m->solver.radix);
    duet_world_destroy(m->graph.world);
    program_set_close(m->programs);
    gen_close(m->gen);
    free(m->poses);
    free(m->cells);
    free(m->bodies);
    motion_free_events(&m->told);
    ground_close(&m->ground);
    motion_forget_moved(&m->reading);
    free(m->altered.places);
    motion_forget_commands(m->commands);
    motion_forget_recording(m);
    duet_device_pair_destroy(m->def.pair);
    free(m);
}
