// SPDX-License-Identifier: MIT
// A world's objects: of which kind they are, and where they are seen.
#include "runtime/broadphase/world.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

#include <string.h>

// ---------------------------------------------------------------- kinds

static const struct {
    const char *name;
    size_t bytes; // a row's
} kinds[] = {
    [DUET_OBJECT_POSES] = {"poses", sizeof(duet_pose)},
    [DUET_OBJECT_BOUNDS] = {"bounds", sizeof(duet_bounds)},
    [DUET_OBJECT_LARGE_POSES] = {"large poses", sizeof(duet_large_pose)},
    [DUET_OBJECT_TRANSFORMS] = {"transforms", sizeof(duet_transform)},
    [DUET_OBJECT_SIZES] = {"sizes", sizeof(duet_size)},
    [DUET_OBJECT_COMPACT_TRANSFORMS] = {"compact transforms", sizeof(duet_compact_transform)},
    [DUET_OBJECT_ROUNDED_BOXES] = {"rounded boxes", sizeof(duet_rounded_box)},
    [DUET_OBJECT_SPHERES] = {"spheres", sizeof(duet_sphere)},
};

duet_object_kind world_objects_kind(const duet_world_def *def)
{
    duet_object_kind whole = origin_row_kind(def->shape, def->origin_edge);
    return whole != DUET_OBJECT_POSES || !def->pose_form ? whole
           : def->pose_form == DUET_POSE_COMPACT         ? DUET_OBJECT_COMPACT_TRANSFORMS
                                                         : DUET_OBJECT_TRANSFORMS;
}

const char *world_kind_name(duet_object_kind kind)
{
    return kinds[kind].name;
}

size_t world_kind_bytes(duet_object_kind kind)
{
    return kinds[kind].bytes;
}

const char *world_objects_name(const duet_world_def *def)
{
    return kinds[world_objects_kind(def)].name;
}

// ---------------------------------------------------------------- in a device's memory

static bool has_bound(const duet_world *world, int side)
{
    return world->parts[side].objects.bound.mem;
}

void world_renew_objects(duet_world *world)
{
    ++world->objects.all.generation;
    world->stats.n = 0;
}

void world_bind_resident(duet_world *world, resident r, size_t bytes, const bool on[2], uint32_t n)
{
    const buffer memory = {.mem = r.mem, .bytes = bytes};
    world_drop_resident(world);
    world->resident = r;
    world->objects.all.rows = NULL;
    world->objects.all.n = n;
    world_renew_objects(world);
    for (int side = 0; side < 2; ++side)
        view_bind(&world->parts[side].objects, on[side] ? &memory : NULL);
}

void resident_release(resident *r)
{
    mem_release(&r->mem);
    callers_events_release(&r->ready);
    *r = (resident){0};
}

void world_drop_resident(duet_world *world)
{
    resident_release(&world->resident);
    for (int side = 0; side < 2; ++side)
        view_bind(&world->parts[side].objects, NULL);
}

// The part whose device shows the host the objects: in place, if one works on host memory.
static part *shown_by(duet_world *world)
{
    part *a = &world->parts[0], *b = &world->parts[1];
    bool in_place =
        has_bound(world, 0) && a->device->info.host_memory && !b->device->info.host_memory;
    return has_bound(world, 1) && !in_place ? b : a;
}

static bool map_resident(duet_world *world, size_t bytes, const device *d, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    world->objects.all.rows = clEnqueueMapBuffer(d->queue, world->resident.mem, CL_TRUE,
                                                 CL_MAP_READ, 0, bytes, 0, NULL, NULL, &code);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: mapping %zu bytes of objects", d->info.selector, bytes);
}

// The part of the device that has them takes the time.
static bool fetch_resident(duet_world *world, size_t bytes, part *from, duet_error *err)
{
    timeline_begin(&from->times, from->device, true);
    if (!host_block_reserve(&world->objects_block, world->def.pair->devices, 2, bytes, err) ||
        !timeline_read(&from->times, "fetch objects", &from->objects.bound,
                       world->objects_block.bytes, bytes, err))
        return false;
    world->objects.all.rows = world->objects_block.bytes;
    return true;
}

void world_unmap_objects(duet_world *world)
{
    bool mapped = world->resident.mem && world->objects.all.rows &&
                  world->objects.all.rows != world->objects_block.bytes;
    if (!mapped)
        return;
    const device *d = shown_by(world)->device;
    clEnqueueUnmapMemObject(d->queue, world->resident.mem, (void *)world->objects.all.rows, 0, NULL,
                            NULL);
    clFinish(d->queue);
    world->objects.all.rows = NULL;
}

// ---------------------------------------------------------------- what the host sees

static bool see(duet_world *world, duet_error *err)
{
    size_t bytes = world->objects.all.n * world->objects.all.row_bytes;
    if (world->objects.all.rows || bytes == 0)
        return true;
    part *p = shown_by(world);
    return p->device->info.host_memory ? map_resident(world, bytes, p->device, err)
                                       : fetch_resident(world, bytes, p, err);
}

// To send objects that one device has to the other, or to decide in a device's memory what float
// leaves open.
static bool search_sees(const duet_world *world)
{
    const duet_plan *plan = &world->def.plan;
    const bool searches[2] = {plan->share > 0,
                              plan->share < DUET_SHARE_ONE || plan->mode == DUET_MODE_SHARED};
    bool sees = false;
    for (int side = 0; side < 2; ++side)
        sees |= searches[side] &&
                (!has_bound(world, side) || (world->def.shape == DUET_SHAPE_POSES &&
                                             world->parts[side].device->info.host_memory));
    return sees;
}

static bool has_sizes(const duet_world *world, duet_error *err)
{
    return !world->def.pose_form || world->objects.sizes.n == world->objects.all.n ||
           bad_argument(err, "%u objects have a transform and %u a size; expected as many of each",
                        world->objects.all.n, world->objects.sizes.n);
}

bool world_take_objects(duet_world *world, bool seen, duet_error *err)
{
    return has_sizes(world, err) &&
           callers_events_wait(&world->resident.ready, "the objects", err) &&
           (!(seen || search_sees(world)) || see(world, err));
}
