// SPDX-License-Identifier: MIT
// A program with OpenCL of its own: one context with both halves of a CPU, or with a device twice.
#ifndef TESTS_OWN_PROGRAM_H
#define TESTS_OWN_PROGRAM_H

#include "runtime/duet_opencl.h"

typedef struct own_program {
    cl_device_id root, ids[2];
    bool cut; // the ids are halves of the root
    cl_context context;
    cl_command_queue queues[2];
} own_program;

extern own_program own;

void own_program_open(void); // which the tests keep

// A buffer that the test keeps; bytes NULL: nothing is written into it.
cl_mem own_buffer(const void *bytes, size_t size, cl_mem_flags flags);

// Reads a buffer by one of the queues, once `after` is over unless it is NULL.
void own_read(int queue, cl_mem mem, void *to, size_t bytes, const cl_event *after);

cl_uint own_references(cl_mem mem);
cl_uint own_queue_references(int i);

#endif
