// SPDX-License-Identifier: MIT
#include "runtime/broadphase/resident.h"

#include "base/error.h"

bool resident_await(resident *r, duet_error *err)
{
    return callers_events_wait(&r->ready, "the objects", err);
}

// The device whose objects the host sees: in place where one works on host memory.
static int side_of(const resident *r, const device devices[2])
{
    bool in_place = r->on[0] && devices[0].info.host_memory && !devices[1].info.host_memory;
    return r->on[1] && !in_place ? 1 : 0;
}

static bool map(resident *r, size_t bytes, const device *d, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    r->mapped = clEnqueueMapBuffer(d->queue, r->objects.mem, CL_TRUE, CL_MAP_READ, 0, bytes, 0,
                                   NULL, NULL, &code);
    r->seen = r->mapped;
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: mapping %zu bytes of objects", d->info.selector, bytes);
}

static bool fetch(resident *r, size_t bytes, host_block *block, const device devices[2],
                  const device *d, timeline *t, duet_error *err)
{
    timeline_begin(t, d);
    if (!host_block_reserve(block, devices, 2, bytes, err) ||
        !timeline_read(t, "fetch objects", &r->objects, block->bytes, bytes, err))
        return false;
    r->seen = block->bytes;
    return true;
}

bool resident_see(resident *r, size_t bytes, host_block *block, const device devices[2],
                  part parts[2], duet_error *err)
{
    int side = side_of(r, devices);
    if (!r->objects.mem || r->seen || bytes == 0)
        return true;
    return devices[side].info.host_memory
               ? map(r, bytes, &devices[side], err)
               : fetch(r, bytes, block, devices, &devices[side], &parts[side].times, err);
}

void resident_end_sight(resident *r, const device devices[2])
{
    if (!r->mapped)
        return;
    const device *d = &devices[side_of(r, devices)];
    clEnqueueUnmapMemObject(d->queue, r->objects.mem, r->mapped, 0, NULL, NULL);
    clFinish(d->queue);
    r->seen = r->mapped = NULL;
}

void resident_drop(resident *r)
{
    if (r->callers)
        callers_buffer_release(&r->objects.mem);
    callers_events_release(&r->ready);
    *r = (resident){0};
}
