// SPDX-License-Identifier: MIT
#include "runtime/opencl/device.h"

#include <assert.h>
#include <stdatomic.h>

static atomic_int live_objects;

void device_object_made(void)
{
    atomic_fetch_add(&live_objects, 1);
}

void device_object_gone(void)
{
    int before = atomic_fetch_sub(&live_objects, 1);
    assert(before > 0);
    (void)before;
}

int device_live_objects(void)
{
    return atomic_load(&live_objects);
}
