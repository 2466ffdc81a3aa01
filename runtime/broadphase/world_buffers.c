// SPDX-License-Identifier: MIT
// A world's objects from a buffer of the caller's, and its pairs in one.
#include "runtime/broadphase/world.h"

#include "base/error.h"
#include "runtime/opencl/callers_buffer.h"

// ---------------------------------------------------------------- objects

// Each queue of the caller's that has the buffer, once.
static bool mark_queues(resident *r, const device devices[2], duet_error *err)
{
    bool same = devices[0].callers == devices[1].callers;
    bool ok = !r->on[0] || callers_events_mark(&r->ready, &devices[0], err);
    return ok &&
           (!r->on[1] || (r->on[0] && same) || callers_events_mark(&r->ready, &devices[1], err));
}

static bool take_sizes(duet_world *world, resident *r, uint32_t n, duet_error *err)
{
    const device *devices = world->def.pair->devices;
    const int side = r->on[1] ? 1 : 0;
    duet_size *sizes = duet_world_map_objects(world, DUET_OBJECT_SIZES, n, err);
    if (!sizes || !resident_await(r, err))
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
    world_kind what;
    resident r = {0};
    cl_context context = NULL;
    if (!world_can_have(world, kind, n, __func__, &what, err))
        return false;
    if (n == 0)
        return duet_world_map_objects(world, kind, 0, err) != NULL;
    const device *devices = world->def.pair->devices;
    const buffer_need need = {__func__, "objects", BUFFER_READ, n * what.bytes};
    if (!callers_buffer_check(objects, &need, devices, -1, r.on, err))
        return false;
    clGetMemObjectInfo(objects, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    if (!callers_events_check(n_events, events, context, __func__, err))
        return false;
    r.objects = (buffer){.mem = callers_buffer_hold(objects), .bytes = need.bytes};
    r.callers = true;
    bool ok = callers_events_hold(&r.ready, n_events, events, err) && mark_queues(&r, devices, err);
    if (!ok || kind == DUET_OBJECT_SIZES) {
        ok = ok && take_sizes(world, &r, n, err);
        resident_drop(&r);
        return ok;
    }
    resident_drop(&world->resident);
    world->resident = r;
    world->n = n;
    ++world->objects_version;
    return true;
}

// ---------------------------------------------------------------- pairs

bool duet_world_leave_pairs(duet_world *world, int side, cl_mem pairs, cl_mem count,
                            duet_error *err)
{
    if (!world_is_idle(world, __func__, err))
        return false;
    if (side != 0 && side != 1)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: device is %d; expected 0 for A, 1 for B", __func__, side);
    const device *devices = world->def.pair->devices;
    const buffer_need pairs_need = {__func__, "pairs", BUFFER_WRITTEN, sizeof(duet_pair)};
    const buffer_need count_need = {__func__, "count", BUFFER_WRITTEN, sizeof(cl_ulong)};
    bool has[2];
    if ((pairs && !callers_buffer_check(pairs, &pairs_need, devices, side, has, err)) ||
        (count && !callers_buffer_check(count, &count_need, devices, side, has, err)))
        return false;
    size_t bytes = 0;
    if (pairs)
        clGetMemObjectInfo(pairs, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    callers_buffer_hold(pairs);
    callers_buffer_hold(count);
    pair_buffers_drop(&world->left);
    world->left = (pair_buffers){.device = &devices[side],
                                 .pairs = pairs,
                                 .count = count,
                                 .capacity = bytes / sizeof(duet_pair)};
    return true;
}

bool duet_world_bring_pairs(duet_world *world, duet_error *err)
{
    if (!world_is_idle(world, __func__, err))
        return false;
    pair_buffers_drop(&world->left);
    return true;
}

bool duet_world_get_pair_buffers(duet_world *world, duet_pair_buffers *buffers, duet_error *err)
{
    if (!world_is_idle(world, __func__, err) || !error_given(buffers, __func__, "buffers", err))
        return false;
    *buffers = world->left.last;
    return buffers->pairs ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%s: no step has left its pairs in a buffer; expected duet_world_leave_pairs, "
                     "then a step",
                     __func__);
}
