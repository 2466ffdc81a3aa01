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

// ---------------------------------------------------------------- who does what

// Leaves pairs on a device if the other one can read them there. A device on host memory gains
// nothing by it, unless the pairs are wanted in its own buffer.
static bool pairs_on_device(const duet_world *world, int side)
{
    const device *to = world->left.device, *from = world->parts[side].device;
    return to && (from == to || (!from->info.host_memory && from->context == to->context));
}

static grid_role role_of(const duet_world *world, int side)
{
    const bool shared = world->def.plan.mode == DUET_MODE_SHARED;
    return !shared ? GRID_OWN : side == 0 ? GRID_RECEIVED : GRID_BUILT;
}

// The paper's kernels read every object by its id. Each device marks the blocks that the other one
// needs, so that both read ranges or none does.
static bool selects_ranges(const duet_world *world)
{
    return world->def.ordered && world->def.plan.mode == DUET_MODE_SLAB &&
           world->variants[0].search != SEARCH_PAPER && world->variants[1].search != SEARCH_PAPER;
}

static bool has_work(const part_range *range)
{
    return range->first < range->last;
}

// A device with memory of its own gets a list of its slab's objects, if the variant asks for it and
// that leaves out enough. The kernels know lists of poses and bounds alone.
static bool selects_list(const duet_world *world, const part_range ranges[2], int side)
{
    const grid_objects *o = &world->objects;
    const part *p = &world->parts[side];
    const variant *v = &world->variants[side];
    const bool plain = (o->shape == DUET_SHAPE_POSES || o->shape == DUET_SHAPE_BOUNDS) &&
                       o->origin == 0.0f && !o->sizes.rows;
    return world->def.plan.mode == DUET_MODE_SLAB && plain && v->search == SEARCH_GPU &&
           v->send == SEND_PACKED && !p->device->info.host_memory && !p->objects.bound.mem &&
           has_work(&ranges[0]) && has_work(&ranges[1]) && compaction_pays(&ranges[side], o->all.n);
}

static selection select_objects(const duet_world *world, const part_range ranges[2], int side)
{
    const part_range *slab = &ranges[side];
    if (selects_ranges(world))
        return world->ranges.selections[side];
    return selects_list(world, ranges, side)
               ? (selection){SELECT_LIST, .key_from = slab->key_from, .key_to = slab->key_to}
               : select_all(world->objects.all.n);
}

// Which objects each part searches around: parts of one sorted order, or slabs.
static bool divide(duet_world *world, part_range ranges[2], duet_error *err)
{
    const uint32_t share = world->def.plan.share, n_cells = world->grid.n_cells;
    const uint32_t n = world->objects.all.n;
    if (world->def.plan.mode == DUET_MODE_SLAB)
        return split_cut(&world->split, &world->grid, &world->objects, share, ranges, err) &&
               (!selects_ranges(world) || input_ranges_begin(&world->ranges, n, ranges, err));
    uint32_t cut = (uint32_t)((uint64_t)n * share / DUET_SHARE_ONE);
    part_range whole = {.home_to = n_cells, .key_to = n_cells, .expected = n};
    ranges[0] = ranges[1] = whole;
    ranges[0].last = ranges[1].first = cut;
    ranges[1].last = n;
    return true;
}

static void give_tasks(duet_world *world, const part_range ranges[2])
{
    for (int side = 0; side < 2; ++side) {
        part *p = &world->parts[side];
        const part_task task = {
            .def = &world->def,
            .objects = &world->objects,
            .grid = &world->grid,
            .role = role_of(world, side),
            .other = &world->parts[1 - side],
            .range = ranges[side],
            .wanted = select_objects(world, ranges, side),
            .lists = &world->lists,
            .ids = p->device->info.host_memory ? NULL : world->counted,
            .pairs_on_device = pairs_on_device(world, side),
            .moves = world->moves,
        };
        part_take(p, &task);
    }
}

// ---------------------------------------------------------------- built ahead

// Slabs have one size of cells.
static uint32_t list_grids(const duet_world *world, bool spreads, part_grid_kind kinds[3])
{
    const bool slabs = world->asked_mode == DUET_MODE_SLAB;
    const bool cut =
        slabs || (world->asked_mode == DUET_MODE_DEFAULT && world_pair_is_alike(world->def.pair));
    uint32_t n = 0;
    if (world->wish.kinds != GRID_ONLY_HASHED)
        kinds[n++] = (part_grid_kind){GRID_DENSE, true, cut};
    if (world->wish.kinds != GRID_ONLY_HASHED)
        kinds[n++] = (part_grid_kind){GRID_DENSE, false, slabs};
    if (world->wish.kinds == GRID_ONLY_HASHED || (world->wish.kinds == GRID_ANY && spreads))
        kinds[n++] = (part_grid_kind){GRID_HASHED, false, false};
    return n;
}

static bool may_work(const duet_world *world, int side)
{
    const duet_plan *plan = &world->def.plan;
    return plan->share != (side == 0 ? 0 : DUET_SHARE_ONE) || plan->mode == DUET_MODE_SHARED;
}

bool world_expect_motion(duet_world *world, bool spreads, duet_error *err)
{
    part_grid_kind kinds[3];
    const uint32_t n = list_grids(world, spreads, kinds);
    bool ok = true;
    world->moves = true;
    if (world->variants[0].search == SEARCH_PAPER || world->variants[1].search == SEARCH_PAPER)
        return true; // it knows one kind of grid
    give_tasks(world, (const part_range[2]){{0}, {0}});
    for (int side = 0; ok && side < 2; ++side)
        ok = !may_work(world, side) ||
             part_prepare_grids(&world->parts[side], &world->variants[side], kinds, n, err);
    return ok;
}

// ---------------------------------------------------------------- both parts

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

// *found_all is false if a slab had more objects than space, or a requested block was not selected:
// both are known then, and the parts are to be run again.
static bool run_parts(duet_world *world, bool *found_all, duet_error *err)
{
    part *a = &world->parts[0], *b = &world->parts[1];
    part_range ranges[2];
    if (!divide(world, ranges, err))
        return false;
    give_tasks(world, ranges);
    const bool shared = a->task.role == GRID_RECEIVED && has_work(&a->task.range);
    const bool use[2] = {has_work(&a->task.range), shared || has_work(&b->task.range)};
    if ((use[0] && !part_prepare(a, &world->variants[0], err)) ||
        (use[1] && !part_prepare(b, &world->variants[1], err)) ||
        (shared && !part_share_grid(b, a, err)) || !run_both(world, use, err))
        return false;
    const bool crowded = a->state == PART_CROWDED || b->state == PART_CROWDED;
    const block_requests requests[2] = {a->requests.last, b->requests.last};
    if (crowded)
        split_forget(&world->split);
    *found_all =
        !crowded && (!selects_ranges(world) || input_ranges_held(&world->ranges, requests));
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
        for (int side = 0; side < 2; ++side)
            part_begin(&world->parts[side], &world->objects.all, world->steps);
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
