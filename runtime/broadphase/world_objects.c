// SPDX-License-Identifier: MIT
// A world's objects: of which kind they are, and where they are seen.
#include "runtime/broadphase/world.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

#include <string.h>

// ---------------------------------------------------------------- kinds

static const struct {
    const char *name;
    size_t bytes; // of a row
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
    bool apart = whole == DUET_OBJECT_POSES;
    return apart && def->compact_transforms ? DUET_OBJECT_COMPACT_TRANSFORMS
           : apart && def->separate_sizes   ? DUET_OBJECT_TRANSFORMS
                                            : whole;
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

void resident_drop(resident *r)
{
    if (r->callers)
        mem_release(&r->objects.mem);
    callers_events_release(&r->ready);
    *r = (resident){0};
}

// The device whose objects the host sees: in place where one works on host memory.
static int side_of(const resident *r, const device devices[2])
{
    bool in_place = r->on[0] && devices[0].info.host_memory && !devices[1].info.host_memory;
    return r->on[1] && !in_place ? 1 : 0;
}

static bool map_resident(resident *r, size_t bytes, const device *d, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    r->mapped = clEnqueueMapBuffer(d->queue, r->objects.mem, CL_TRUE, CL_MAP_READ, 0, bytes, 0,
                                   NULL, NULL, &code);
    r->seen = r->mapped;
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: mapping %zu bytes of objects", d->info.selector, bytes);
}

// The part of the device that has them takes the time.
static bool fetch_resident(duet_world *world, size_t bytes, part *from, duet_error *err)
{
    resident *r = &world->resident;
    timeline_begin(&from->times, from->device, true);
    if (!host_block_reserve(&world->objects, world->def.pair->devices, 2, bytes, err) ||
        !timeline_read(&from->times, "fetch objects", &r->objects, world->objects.bytes, bytes,
                       err))
        return false;
    r->seen = world->objects.bytes;
    return true;
}

// ---------------------------------------------------------------- seeing them

grid_objects world_objects(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    return (grid_objects){
        .array = world->resident.objects.mem ? world->resident.seen
                 : world->lent               ? world->lent
                                             : world->objects.bytes,
        .row_bytes = kinds[world->kind].bytes,
        .shape = def->shape,
        .origin = def->origin_edge,
        .n = world->n,
        .dims = def->dims,
        .sizes = def->separate_sizes ? world->sizes.bytes : NULL,
        .compact = def->compact_transforms,
    };
}

static bool see(duet_world *world, duet_error *err)
{
    resident *r = &world->resident;
    size_t bytes = world->n * kinds[world->kind].bytes;
    if (!r->objects.mem || r->seen || bytes == 0)
        return true;
    part *p = &world->parts[side_of(r, world->def.pair->devices)];
    return p->device->info.host_memory ? map_resident(r, bytes, p->device, err)
                                       : fetch_resident(world, bytes, p, err);
}

// To send objects that one device has to the other, or to decide in a device's memory what float
// leaves open.
static bool search_sees(const duet_world *world)
{
    const duet_plan *plan = &world->def.plan;
    const resident *r = &world->resident;
    const bool searches[2] = {plan->share > 0,
                              plan->share < DUET_SHARE_ONE || plan->mode == DUET_MODE_SHARED};
    bool sees = false;
    for (int side = 0; side < 2; ++side)
        sees |=
            searches[side] &&
            (!r->on[side] || r->only_seen ||
             (world->def.shape == DUET_SHAPE_POSES && world->parts[side].device->info.host_memory));
    return sees;
}

static bool has_sizes(const duet_world *world, duet_error *err)
{
    return !world->def.separate_sizes || world->n_sizes == world->n ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%u objects have a transform and %u a size; expected as many of each",
                     world->n, world->n_sizes);
}

bool world_take_objects(duet_world *world, bool seen, duet_error *err)
{
    return has_sizes(world, err) &&
           callers_events_wait(&world->resident.ready, "the objects", err) &&
           (!(seen || search_sees(world)) || see(world, err));
}

void world_end_sight(duet_world *world)
{
    resident *r = &world->resident;
    if (!r->mapped)
        return;
    const device *d = &world->def.pair->devices[side_of(r, world->def.pair->devices)];
    clEnqueueUnmapMemObject(d->queue, r->objects.mem, r->mapped, 0, NULL, NULL);
    clFinish(d->queue);
    r->seen = r->mapped = NULL;
}
