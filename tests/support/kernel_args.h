// SPDX-License-Identifier: MIT
// Arguments of two small kernels that tests launch by themselves: cell_start and clear.
#ifndef SUPPORT_KERNEL_ARGS_H
#define SUPPORT_KERNEL_ARGS_H

#include "runtime/opencl/buffer.h"
#include "runtime/opencl/program.h"

typedef struct cell_start_args {
    buffer keys, starts;
    cl_uint n, end;
} cell_start_args;

static const binding cell_start_bindings[] = {
    BIND_BUFFER(cell_start_args, "keys", "uint *", keys),
    BIND_BUFFER(cell_start_args, "key_starts", "uint *", starts),
    BIND_VALUE(cell_start_args, "n_keys", n),
    BIND_VALUE(cell_start_args, "key_end", end),
    {0}};

typedef struct clear_args {
    buffer counters, counts;
    cl_uint n_counters, n_counts;
} clear_args;

static const binding clear_bindings[] = {BIND_BUFFER(clear_args, "counters", "uint *", counters),
                                         BIND_BUFFER(clear_args, "counts", "uint *", counts),
                                         BIND_VALUE(clear_args, "n_counters", n_counters),
                                         BIND_VALUE(clear_args, "n_counts", n_counts),
                                         {0}};

#endif
