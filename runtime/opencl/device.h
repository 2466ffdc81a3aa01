// SPDX-License-Identifier: MIT
// One OpenCL device that we work on.
//
// Each has queues of its own, and a context of its own, also where two are parts of one
// CPU: all pairs of devices, of one platform or of two, then work alike, and
// parts of a CPU were measured to run truly side by side this way. A device that is both A and B
// has one context: a GPU's driver takes a tenth of a second and more to make another one, and a
// second where eight processes ask at once. One that is opened on a queue of the caller's has that
// queue's context.
#ifndef RUNTIME_DEVICE_H
#define RUNTIME_DEVICE_H

#include "runtime/opencl/driver.h"

#include <CL/cl.h>

typedef struct program_pool program_pool; // runtime/opencl/program_build.h

typedef struct device {
    cl_device_id id; // held
    cl_context context;
    cl_command_queue queue;   // in order, with profiling
    cl_command_queue beside;  // the same, for what is sent while kernels run
    cl_command_queue callers; // queue whose context and device these are; NULL: our own
    duet_device_info info;
    uint32_t quirks; // the driver's
    program_pool *built;
} device;

// The folder of built programs, and the callback for compiled ones.
typedef struct program_builder {
    const char *cache_dir; // NULL: no cache of ours
    bool is_default;       // the user's folder, which nobody named
    duet_compile_callback *on_compile;
    void *context;
} program_builder;

// Whether built programs of a device are kept.
bool program_builder_keeps(const program_builder *b, const duet_device_info *info);

// Opens what a selector names: "pocl:0", or units 2 to 3 of it: "pocl:0[2-3]".
// NO_DEVICE where there is none at all, BAD_ARGUMENT for an unknown one,
// BAD_ARGUMENT for a part that cannot be had; *d is then empty.
bool device_open(device *d, const char *selector, duet_error *err);
// The same, in the context of first, unless NULL, where that is the same device.
bool device_open_beside(device *d, const char *selector, const device *first, duet_error *err);
// Opens the device of a queue of the caller's in the queue's context.
bool device_open_on_queue(device *d, cl_command_queue queue, duet_error *err);
void device_close(device *d); // an empty one is passed over

// Gets all that the driver says about a device; the list sets the selector. Fields that a driver
// does not answer stay empty or 0.
void device_info_read(cl_device_id id, duet_device_info *info);

// OpenCL objects of ours that are alive. Drivers hide a forgotten release from
// leak checkers, so each object is counted where it is made and where it is released, and tests
// assert 0 at their end.
void device_object_made(void);
void device_object_gone(void);
int device_live_objects(void);

#endif
