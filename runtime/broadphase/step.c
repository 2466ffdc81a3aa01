// SPDX-License-Identifier: MIT
// A step: fit the grid, let both devices find the pairs of their objects at the same time, and hand
// out what they found.
//
// A takes the first share of the objects in cell order and B the rest. Each pair is found from its
// first object, so no pair is found twice and none is lost between the parts.
//
//   fit the grid -> divide -> select -> prepare -> both parts at once: update the views,
//        ^                                         build or receive the grid, search
//        |                                                   |
//        +--- an object is wider than a cell, a slab has more objects than space, or a
//             requested block was not selected (input_ranges.h)
#include "runtime/broadphase/world.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <math.h>

// ---------------------------------------------------------------- parts

// The slab whose objects are to be listed, or NULL.
static const part_range *slab_to_list(const part *p)
{
    const part_task *task = &p->task;
    bool lists = task->wanted.kind == SELECT_LIST &&
                 !view_has(&p->objects, task->objects->all.generation, &task->wanted);
    return lists ? &task->range : NULL;
}

// An object's slab is known only once its row of cells is: all threads list each device's objects
// while the parts run.
static bool run_both(duet_world *world, const bool use[2], duet_error *err)
{
    part *a = &world->parts[0], *b = &world->parts[1];
    const part_range *const slabs[2] = {slab_to_list(a), slab_to_list(b)};
    const device *const devices[2] = {a->device, b->device};
    thread_pool *threads = NULL;
    if (!compaction_start(&world->lists, &world->objects, &world->grid, slabs, devices, &threads,
                          err))
        return false;
    thread_pool_run_both(world->driver, part_run, use[0] ? a : NULL, use[1] ? b : NULL);
    thread_pool_wait(threads);
    if (a->state != PART_FAILED && b->state != PART_FAILED)
        return true;
    error_copy(err, &a->err);
    return error_copy(err, &b->err);
}

// A prefetched part began when that started.
static void begin_parts(duet_world *world)
{
    for (int side = 0; side < 2; ++side)
        if (world->objects.all.n == 0 ||
            !view_is_prefetched(&world->parts[side].objects, world->objects.all.generation))
            part_begin(&world->parts[side], world->steps);
}

// *found_all is false if a slab had more objects than space, or a requested block was not selected:
// both are known then, and the parts are to be run again.
static bool run_parts(duet_world *world, bool *found_all, duet_error *err)
{
    part *a = &world->parts[0], *b = &world->parts[1];
    if (!world_give_tasks(world, err))
        return false;
    const bool shared = a->task.role == GRID_RECEIVED && part_range_has_work(&a->task.range);
    const bool use[2] = {part_range_has_work(&a->task.range),
                         shared || part_range_has_work(&b->task.range)};
    if ((use[0] && !part_prepare(a, &world->variants[0], err)) ||
        (use[1] && !part_prepare(b, &world->variants[1], err)) ||
        (shared && !part_share_grid(b, a, err)) || !run_both(world, use, err))
        return false;
    const bool crowded = a->state == PART_CROWDED || b->state == PART_CROWDED;
    const block_requests requests[2] = {a->requests.last, b->requests.last};
    if (crowded)
        split_forget(&world->split);
    *found_all =
        !crowded && (!world_selects_ranges(world) || input_ranges_held(&world->ranges, requests));
    return true;
}

// ---------------------------------------------------------------- a step

// Cells that are too small, a slab without space, blocks that were not selected. A second widening
// would mean that objects grew while the step ran.
enum { MOST_FITS = 4 };

static bool find_all(duet_world *world, duet_error *err)
{
    bool fits = false;
    for (int fit = 0; !fits; ++fit) {
        begin_parts(world);
        if (!budget_check(err) || !world_fit_grid(world, false, NULL, err))
            return false;
        if (world->objects.all.n == 0)
            return true;
        bool found_all = false;
        if (!run_parts(world, &found_all, err))
            return false;
        float widest =
            fmaxf(world->parts[0].result.found.widest, world->parts[1].result.found.widest);
        if (widest > 0.0f)
            world->fitted_n = 0;
        fits = found_all && !(widest > 0.0f);
        if (!fits && fit == MOST_FITS)
            return error_set(err, DUET_STATUS_CELL_TOO_SMALL,
                             "an object's extent of %g does not fit a cell of %g", widest,
                             world->grid.edge);
    }
    return true;
}

static bool find_pairs(duet_world *world, duet_error *err)
{
    bool ok = find_all(world, err);
    ++world->steps;
    world_unmap_objects(world);
    return ok;
}

bool world_step(duet_world *world, duet_result *result, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    if (world->def.stage_times)
        world->steps = 0;
    bool found = find_pairs(world, err);
    return world_hand_out(world, found, begun, result, err);
}

bool duet_world_step(duet_world *world, duet_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    return world_is_idle(world, __func__, err) && error_given(result, __func__, "result", err) &&
           world_step(world, result, err);
}

bool world_step_resident(duet_world *world, const buffer *bounds, uint32_t n, bool untimed,
                         duet_result *result, const buffer **pairs, duet_error *err)
{
    static const bool on_b[2] = {false, true};
    uint64_t begun = clock_steady_ns();
    world_bind_resident(world, (resident){.mem = callers_buffer_hold(bounds->mem)}, bounds->bytes,
                        on_b, n);
    world->left.device = world->parts[1].device;
    world->steps = untimed ? 1 : 0;
    bool ok = world_hand_out(world, find_pairs(world, err), begun, result, err);
    world_drop_resident(world);
    *pairs = world->left.joined;
    return ok;
}

// ---------------------------------------------------------------- counted

bool world_step_counting(duet_world *world, const global_ids *ids, duet_result *result,
                         part_counted counted[2], duet_error *err)
{
    const uint64_t before = world->ids.generation;
    world->ids = *ids;
    world->ids.generation = before + (before == 0 || ids->n_changed > 0);
    world->counted = &world->ids;
    bool ok = duet_world_step(world, result, err);
    world->counted = NULL;
    for (int side = 0; side < 2; ++side)
        counted[side] = world->parts[side].result.counted;
    return ok;
}

bool world_read_counted(duet_world *world, duet_span spans[2], duet_error *err)
{
    bool ok = true;
    for (int side = 0; ok && side < 2; ++side) {
        ok = part_read_counted(&world->parts[side], err);
        spans[side] = world->parts[side].result.span;
    }
    return ok;
}
