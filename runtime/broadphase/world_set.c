// SPDX-License-Identifier: MIT
// A world's objects, as the caller sets them: as arrays, in place, or in a buffer of the caller's.
#include "runtime/broadphase/world.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

#include <string.h>

static bool can_have(const duet_world *world, duet_object_kind kind, uint32_t n, const char *call,
                     duet_error *err)
{
    if (!world_is_idle(world, call, err))
        return false;
    if (kind < DUET_OBJECT_POSES || kind > DUET_OBJECT_SPHERES)
        return bad_argument(err, "kind is %d; expected a duet_object_kind", (int)kind);
    bool size = kind == DUET_OBJECT_SIZES && world->def.pose_form;
    if (kind != world->objects.kind && !size)
        return bad_argument(err, "the world was made for %s, not for %s",
                            world_kind_name(world->objects.kind), world_kind_name(kind));
    return n <= DUET_MOST_OBJECTS ||
           error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a world holds at most %u", n,
                     DUET_MOST_OBJECTS);
}

// The row behind the last belongs to none: a device may read four numbers at once.
static void *map_sizes(duet_world *world, uint32_t n, duet_error *err)
{
    world->objects.sizes.n = 0; // in case there is no memory: the old block is gone
    if (!host_block_reserve(&world->sizes_block, world->def.pair->devices, 2,
                            ((size_t)n + 1) * sizeof(duet_size), err))
        return NULL;
    duet_size *sizes = world->sizes_block.bytes;
    sizes[n] = (duet_size){0};
    world->objects.sizes.rows = sizes;
    world->objects.sizes.n = n;
    ++world->objects.sizes.generation;
    return sizes;
}

void *duet_world_map_objects(duet_world *world, duet_object_kind kind, uint32_t n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!can_have(world, kind, n, __func__, err))
        return NULL;
    if (kind == DUET_OBJECT_SIZES)
        return map_sizes(world, n, err);
    world_drop_resident(world);
    world->objects.all.rows = NULL;
    world->objects.all.n = 0; // in case there is no memory: the old block is gone
    if (!host_block_reserve(&world->objects_block, world->def.pair->devices, 2,
                            n * world_kind_bytes(kind), err))
        return NULL;
    world_renew_objects(world);
    return world_extend_objects(world, kind, n);
}

void *world_extend_objects(duet_world *world, duet_object_kind kind, uint32_t n)
{
    if (n * world_kind_bytes(kind) > world->objects_block.size)
        return NULL;
    world->objects.all.rows = world->objects_block.bytes;
    world->objects.all.n = n;
    return world->objects_block.bytes;
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
    void *to = duet_world_map_objects(world, world->objects.kind, n, err);
    for (uint32_t i = 0; to && i < n; ++i) {
        duet_transform t = grid_transform_of(&poses[i]);
        if (world->def.dims == 2)
            t.rotation[0] = t.rotation[1] = 0.0f;
        if (world->def.pose_form == DUET_POSE_TRANSFORM)
            ((duet_transform *)to)[i] = t;
        else // the step reports a pose without rotation
            duet_compact_transform_set(&((duet_compact_transform *)to)[i], &t, NULL);
    }
    return to;
}

// The first objects are counted while they are copied, so that loading a profile need not read
// them again. A step reports an offset that is not a number. objects may be NULL if n is 0.
bool duet_world_set_objects(duet_world *world, duet_object_kind kind, const void *objects,
                            uint32_t n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err) ||
        (n > 0 && !error_given(objects, __func__, "objects", err)))
        return false;
    if (kind == DUET_OBJECT_POSES && world->def.pose_form)
        return world_take_transforms(world, objects, n, err) && take_sizes(world, objects, n, err);
    void *to = duet_world_map_objects(world, kind, n, err);
    if (!to || n == 0)
        return to;
    memcpy(to, objects, n * world_kind_bytes(kind));
    for (uint32_t i = 0; kind == DUET_OBJECT_LARGE_POSES && i < n; ++i)
        origin_settle(&((duet_large_pose *)to)[i], world->def.origin_edge);
    if (kind != DUET_OBJECT_SIZES && world->objects.all.generation == 1 && !world->def.pose_form)
        workload_stats_take(&world->stats, world);
    return true;
}

// ---------------------------------------------------------------- in the caller's buffer

// Each queue of the caller's that has the buffer, once.
static bool mark_queues(resident *r, const bool on[2], const device devices[2], duet_error *err)
{
    bool same = devices[0].callers == devices[1].callers;
    bool ok = !on[0] || callers_events_mark(&r->ready, &devices[0], err);
    return ok && (!on[1] || (on[0] && same) || callers_events_mark(&r->ready, &devices[1], err));
}

static bool fetch_sizes(duet_world *world, resident *r, const device *from, uint32_t n,
                        duet_error *err)
{
    duet_size *sizes = duet_world_map_objects(world, DUET_OBJECT_SIZES, n, err);
    bool ok = sizes && callers_events_wait(&r->ready, "the objects", err);
    cl_int code = ok ? clEnqueueReadBuffer(from->queue, r->mem, CL_TRUE, 0, n * sizeof *sizes,
                                           sizes, 0, NULL, NULL)
                     : CL_SUCCESS;
    if (code != CL_SUCCESS)
        ok = error_set_cl(err, code, "%s: fetching %u sizes", from->info.selector, n);
    if (!ok)
        world->objects.sizes.n = 0; // their content is unknown
    return ok;
}

bool duet_world_set_objects_buffer(duet_world *world, duet_object_kind kind, cl_mem objects,
                                   uint32_t n, cl_uint n_events, const cl_event *events,
                                   duet_error *err)
{
    PUBLIC_CALL(err);
    resident r = {0};
    bool on[2];
    cl_context context = NULL;
    if (!can_have(world, kind, n, __func__, err))
        return false;
    if (n == 0)
        return duet_world_map_objects(world, kind, 0, err) != NULL;
    const device *devices = world->def.pair->devices;
    const buffer_need need = {__func__, "objects", BUFFER_READ, n * world_kind_bytes(kind)};
    if (!callers_buffer_check(objects, &need, devices, -1, on, err))
        return false;
    clGetMemObjectInfo(objects, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    if (!callers_events_check(n_events, events, context, __func__, err))
        return false;
    r.mem = callers_buffer_hold(objects);
    bool ok =
        callers_events_hold(&r.ready, n_events, events, err) && mark_queues(&r, on, devices, err);
    if (ok && kind != DUET_OBJECT_SIZES) {
        world_bind_resident(world, r, need.bytes, on, n);
        return true;
    }
    ok = ok && fetch_sizes(world, &r, &devices[on[1] ? 1 : 0], n, err);
    resident_release(&r);
    return ok;
}
