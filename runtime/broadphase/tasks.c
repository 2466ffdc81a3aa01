// SPDX-License-Identifier: MIT
// Who does what in a step: each device's part of the grid, the objects that it reads for that, and
// where its pairs stay.
#include "runtime/broadphase/world.h"

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
bool world_selects_ranges(const duet_world *world)
{
    return world->def.ordered && world->def.plan.mode == DUET_MODE_SLAB &&
           world->variants[0].search != SEARCH_PAPER && world->variants[1].search != SEARCH_PAPER;
}

// A device with memory of its own gets a list of its slab's objects, if the variant asks for it and
// that leaves out enough. The kernels know lists of poses and bounds alone.
static bool selects_list(const duet_world *world, const part_range ranges[2], int side)
{
    const grid_objects *o = &world->objects;
    const part *p = &world->parts[side];
    const variant *v = &world->variants[side];
    const bool plain = (o->shape == DUET_SHAPE_POSES || o->shape == DUET_SHAPE_BOUNDS) &&
                       o->origin == 0.0f && !grid_has_sizes(o);
    return world->def.plan.mode == DUET_MODE_SLAB && plain && v->search == SEARCH_GPU &&
           v->send == SEND_PACKED && !p->device->info.host_memory && !p->objects.bound.mem &&
           part_range_has_work(&ranges[0]) && part_range_has_work(&ranges[1]) &&
           compaction_pays(&ranges[side], o->all.n);
}

static selection select_objects(const duet_world *world, const part_range ranges[2], int side)
{
    const part_range *slab = &ranges[side];
    if (world_selects_ranges(world))
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
               (!world_selects_ranges(world) || input_ranges_begin(&world->ranges, n, ranges, err));
    uint32_t cut = (uint32_t)((uint64_t)n * share / DUET_SHARE_ONE);
    part_range whole = {.home_to = n_cells, .key_to = n_cells, .expected = n};
    ranges[0] = ranges[1] = whole;
    ranges[0].last = ranges[1].first = cut;
    ranges[1].last = n;
    return true;
}

bool world_give_tasks(duet_world *world, duet_error *err)
{
    part_range ranges[2];
    if (!divide(world, ranges, err))
        return false;
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
        };
        part_take(p, &task);
    }
    return true;
}
