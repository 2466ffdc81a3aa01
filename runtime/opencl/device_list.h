// SPDX-License-Identifier: MIT
// The root devices that OpenCL offers to this process.
//
// OpenCL is asked once and by one thread: PoCL 3.1 crashes where two threads
// make the first call together.
#ifndef RUNTIME_DEVICE_LIST_H
#define RUNTIME_DEVICE_LIST_H

#include "runtime/duet.h"

#include <CL/cl.h>

typedef struct device_root {
    cl_device_id id;
    duet_device_info info;
} device_root;

// All root devices, platform after platform; they last as long as the process.
// NO_DEVICE where there is none.
bool device_list_roots(const device_root **roots, uint32_t *n, duet_error *err);

// Why the i-th of the platforms without a device has none, as a line; NULL past the last. Only to
// be called after device_list_roots.
const char *device_list_absent(uint32_t i);

// Whether PoCL is installed, with devices or without. Only to be called after device_list_roots.
bool device_list_has_pocl(void);

// The one with that id; NULL where there is none.
const device_root *device_list_find(cl_device_id id);

typedef enum device_group { DEVICE_CPU, DEVICE_NO_CPU, DEVICE_GPU } device_group;

// The strongest of a group, by units and clock, but the one passed over; NULL where there
// is none. Only to be called where device_list_roots has found some.
const device_root *device_list_strongest(device_group group, const device_root *passed_over);

#endif
