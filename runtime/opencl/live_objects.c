// SPDX-License-Identifier: MIT
// Counts the objects of OpenCL that exist: tests find what is not released, and scripts pay for
// them.
#include "runtime/opencl/device.h"

#include "base/budget.h"

#include <assert.h>
#include <stdatomic.h>

static atomic_int live_objects;

// About what a driver keeps of one in the host's memory: in PoCL from 30 to 80 KiB, as worlds,
// trees and motions have them.
enum { OBJECT_BYTES = 1 << 16 };

void device_object_made(void)
{
    atomic_fetch_add(&live_objects, 1);
    budget_hold(OBJECT_BYTES);
}

void device_object_gone(void)
{
    int before = atomic_fetch_sub(&live_objects, 1);
    budget_release(OBJECT_BYTES);
    assert(before > 0);
    (void)before;
}

int device_live_objects(void)
{
    return atomic_load(&live_objects);
}
