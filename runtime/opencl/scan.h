// SPDX-License-Identifier: MIT
// Exclusive prefix sums on a device: the host's side of kernels/primitives/scan.cl.
#ifndef RUNTIME_SCAN_H
#define RUNTIME_SCAN_H

#include "runtime/opencl/timeline.h"

typedef struct scan {
    const device *device;
    kernel *block_sums, *top_sums, *blocks;
    buffer sums; // [n_blocks]
    buffer values, to;
    cl_uint n, n_blocks, use_tops;
} scan;

// The rows of its kernels in its owner's list; the owner also names the device, which outlives it.
#define SCAN_KERNELS(scan, wanted)                                       \
    {&(scan)->block_sums, wanted, "scan", "scan_sums", scan_bindings},   \
        {&(scan)->top_sums, wanted, "scan", "scan_tops", scan_bindings}, \
    {                                                                    \
        &(scan)->blocks, wanted, "scan", "scan_blocks", scan_bindings    \
    }
extern const binding scan_bindings[];

// Values whose sum is one of `sums`, as its kernels have it.
#define SCAN_BLOCK(scan) ((scan)->block_sums->group * (scan)->block_sums->per_item)

void scan_close(scan *s);

// Makes space for the sums of n values.
bool scan_reserve(scan *s, uint32_t n, duet_error *err);

// Writes to each of n words the sum of the values before its own; `to` may be the values
// themselves. Kernels built with EMPTIES do not allow that, and set the values to zero.
bool scan_run(scan *s, timeline *t, const char *stage, const buffer *values, const buffer *to,
              uint32_t n, duet_error *err);

// The same where the sums of the blocks are there already: a launch less.
bool scan_run_summed(scan *s, timeline *t, const char *stage, const buffer *values,
                     const buffer *to, uint32_t n, duet_error *err);

#endif
