// SPDX-License-Identifier: MIT
// A world's objects: of which kind they are, how they are set, and where they are seen.
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

const char *world_objects_name(const duet_world_def *def)
{
    return kinds[world_objects_kind(def)].name;
}

static bool can_have(const duet_world *world, duet_object_kind kind, uint32_t n, const char *call,
                     duet_error *err)
{
    if (!world_is_idle(world, call, err))
        return false;
    if (kind < DUET_OBJECT_POSES || kind > DUET_OBJECT_SPHERES)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "kind is %d; expected a duet_object_kind",
                         (int)kind);
    bool size = kind == DUET_OBJECT_SIZES && world->def.separate_sizes;
    if (kind != world->kind && !size)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "the world was made for %s, not for %s",
                         kinds[world->kind].name, kinds[kind].name);
    return n <= UINT32_MAX - 2 ||
           error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a world holds at most %u", n,
                     UINT32_MAX - 2);
}

// ---------------------------------------------------------------- in a device's memory

void resident_drop(resident *r)
{
    if (r->callers)
        callers_buffer_release(&r->objects.mem);
    callers_events_release(&r->ready);
    *r = (resident){0};
}

// The device whose objects the host sees: in place where one works on host memory.
static int side_of(const resident *r, const device devices[2])
{
    bool in_place = r->on[0] && devices[0].info.host_memory && !devices[1].info.host_memory;
    return r->on[1] && !in_place ? 1 : 0;
}

static bool await(resident *r, duet_error *err)
{
    return callers_events_wait(&r->ready, "the objects", err);
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

bool world_see_objects(duet_world *world, duet_error *err)
{
    resident *r = &world->resident;
    size_t bytes = world->n * kinds[world->kind].bytes;
    if (!r->objects.mem || r->seen || bytes == 0)
        return true;
    part *p = &world->parts[side_of(r, world->def.pair->devices)];
    return await(r, err) && (p->device->info.host_memory ? map_resident(r, bytes, p->device, err)
                                                         : fetch_resident(world, bytes, p, err));
}

bool world_see_for_search(duet_world *world, const bool takes_part[2], duet_error *err)
{
    bool needs = false;
    for (int side = 0; side < 2; ++side)
        needs |=
            takes_part[side] &&
            (!world->resident.on[side] || world->resident.only_seen ||
             (world->def.shape == DUET_SHAPE_POSES && world->parts[side].device->info.host_memory));
    return !needs || world_see_objects(world, err);
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

bool world_check_sizes(const duet_world *world, duet_error *err)
{
    return !world->def.separate_sizes || world->n_sizes == world->n ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%u objects have a transform and %u a size; expected as many of each",
                     world->n, world->n_sizes);
}

bool world_await_objects(duet_world *world, duet_error *err)
{
    return world_check_sizes(world, err) && await(&world->resident, err);
}

// ---------------------------------------------------------------- setting them

// The row behind the last belongs to none: a device may read four numbers at once.
static void *map_sizes(duet_world *world, uint32_t n, duet_error *err)
{
    if (!host_block_reserve(&world->sizes, world->def.pair->devices, 2,
                            ((size_t)n + 1) * sizeof(duet_size), err))
        return NULL;
    duet_size *sizes = world->sizes.bytes;
    sizes[n] = (duet_size){0};
    world->n_sizes = n;
    ++world->sizes_version;
    return sizes;
}

void *duet_world_map_objects(duet_world *world, duet_object_kind kind, uint32_t n, duet_error *err)
{
    if (!can_have(world, kind, n, __func__, err))
        return NULL;
    if (kind == DUET_OBJECT_SIZES)
        return map_sizes(world, n, err);
    resident_drop(&world->resident);
    if (!host_block_reserve(&world->objects, world->def.pair->devices, 2, n * kinds[kind].bytes,
                            err))
        return NULL;
    world->lent = NULL;
    world->n = n;
    ++world->objects_version;
    return world->objects.bytes;
}

void *world_extend_objects(duet_world *world, duet_object_kind kind, uint32_t n)
{
    if (n * kinds[kind].bytes > world->objects.size)
        return NULL;
    world->lent = NULL;
    world->n = n;
    return world->objects.bytes;
}

void world_lend_objects(duet_world *world, const void *objects, uint32_t n)
{
    resident_drop(&world->resident);
    world->lent = objects;
    world->n = n;
    ++world->objects_version;
}

static bool take_sizes(duet_world *world, const duet_pose *poses, uint32_t n, duet_error *err)
{
    duet_size *sizes = duet_world_map_objects(world, DUET_OBJECT_SIZES, n, err);
    for (uint32_t i = 0; sizes && i < n; ++i)
        memcpy(sizes[i].half_extents, poses[i].half_extents, sizeof poses->half_extents);
    return sizes;
}

bool world_take_transforms(duet_world *world, const duet_pose *poses, uint32_t n, duet_error *err)
{
    void *to = duet_world_map_objects(world, world->kind, n, err);
    for (uint32_t i = 0; to && i < n; ++i) {
        duet_transform t = grid_transform_of(&poses[i]);
        if (world->def.dims == 2)
            t.rotation[0] = t.rotation[1] = 0.0f;
        if (!world->def.compact_transforms)
            ((duet_transform *)to)[i] = t;
        else // what has no rotation is the step's to report
            duet_compact_transform_set(&((duet_compact_transform *)to)[i], &t, NULL);
    }
    return to;
}

// The first objects are counted while they are copied, so that loading a profile need not read
// them again. A step reports an offset that is not a number. objects may be NULL if n is 0.
bool duet_world_set_objects(duet_world *world, duet_object_kind kind, const void *objects,
                            uint32_t n, duet_error *err)
{
    if (!world_is_idle(world, __func__, err) ||
        (n > 0 && !error_given(objects, __func__, "objects", err)))
        return false;
    if (kind == DUET_OBJECT_POSES && world->def.separate_sizes)
        return world_take_transforms(world, objects, n, err) && take_sizes(world, objects, n, err);
    void *to = duet_world_map_objects(world, kind, n, err);
    if (!to || n == 0)
        return to;
    memcpy(to, objects, n * kinds[kind].bytes);
    for (uint32_t i = 0; kind == DUET_OBJECT_LARGE_POSES && i < n; ++i)
        origin_settle(&((duet_large_pose *)to)[i], world->def.origin_edge);
    if (kind != DUET_OBJECT_SIZES && world->objects_version == 1 && !world->def.separate_sizes)
        workload_stats_take(&world->stats, world);
    return true;
}

// ---------------------------------------------------------------- in the caller's buffer

// Each queue of the caller's that has the buffer, once.
static bool mark_queues(resident *r, const device devices[2], duet_error *err)
{
    bool same = devices[0].callers == devices[1].callers;
    bool ok = !r->on[0] || callers_events_mark(&r->ready, &devices[0], err);
    return ok &&
           (!r->on[1] || (r->on[0] && same) || callers_events_mark(&r->ready, &devices[1], err));
}

static bool fetch_sizes(duet_world *world, resident *r, uint32_t n, duet_error *err)
{
    const device *devices = world->def.pair->devices;
    const int side = r->on[1] ? 1 : 0;
    duet_size *sizes = duet_world_map_objects(world, DUET_OBJECT_SIZES, n, err);
    if (!sizes || !await(r, err))
        return false;
    cl_int code = clEnqueueReadBuffer(devices[side].queue, r->objects.mem, CL_TRUE, 0,
                                      n * sizeof *sizes, sizes, 0, NULL, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: fetching %u sizes", devices[side].info.selector, n);
}

bool duet_world_set_objects_buffer(duet_world *world, duet_object_kind kind, cl_mem objects,
                                   uint32_t n, cl_uint n_events, const cl_event *events,
                                   duet_error *err)
{
    resident r = {0};
    cl_context context = NULL;
    if (!can_have(world, kind, n, __func__, err))
        return false;
    if (n == 0)
        return duet_world_map_objects(world, kind, 0, err) != NULL;
    const device *devices = world->def.pair->devices;
    const buffer_need need = {__func__, "objects", BUFFER_READ, n * kinds[kind].bytes};
    if (!callers_buffer_check(objects, &need, devices, -1, r.on, err))
        return false;
    clGetMemObjectInfo(objects, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    if (!callers_events_check(n_events, events, context, __func__, err))
        return false;
    r.objects = (buffer){.mem = callers_buffer_hold(objects), .bytes = need.bytes};
    r.callers = true;
    bool ok = callers_events_hold(&r.ready, n_events, events, err) && mark_queues(&r, devices, err);
    if (!ok || kind == DUET_OBJECT_SIZES) {
        ok = ok && fetch_sizes(world, &r, n, err);
        resident_drop(&r);
        return ok;
    }
    resident_drop(&world->resident);
    world->resident = r;
    world->n = n;
    ++world->objects_version;
    return true;
}
