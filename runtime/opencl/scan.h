// SPDX-License-Identifier: MIT
// Exclusive prefix sums on a device: the host's side of kernels/primitives/scan.cl.
#ifndef RUNTIME_SCAN_H
#define RUNTIME_SCAN_H

#include "runtime/opencl/timeline.h"

// A GPU has the three launches, a CPU the one. Invariant: no part of `told` has the stamp of a scan
// that was not launched yet.
typedef struct scan {
    const device *device;
    kernel *block_sums, *top_sums, *blocks;
    kernel *at_once;
    buffer sums; // [n_blocks]
    buffer told; // [parts][2] the sum of a part, and the stamp of its scan
    buffer values, to;
    cl_uint n, n_blocks, use_tops, stamp;
} scan;

// The rows of its kernels in its owner's list; the owner names the device, which outlives it,
// before.
#define SCAN_IS_AT_ONCE(scan) ((scan)->device->info.kind == DUET_KIND_CPU)
#define SCAN_ROW(at, wanted, entry)                 \
    {                                               \
        &(at), wanted, "scan", entry, scan_bindings \
    }
#define SCAN_KERNELS(scan, wanted)                                                   \
    SCAN_ROW((scan)->block_sums, (wanted) && !SCAN_IS_AT_ONCE(scan), "scan_sums"),   \
        SCAN_ROW((scan)->top_sums, (wanted) && !SCAN_IS_AT_ONCE(scan), "scan_tops"), \
        SCAN_ROW((scan)->blocks, (wanted) && !SCAN_IS_AT_ONCE(scan), "scan_blocks"), \
        SCAN_ROW((scan)->at_once, (wanted) && SCAN_IS_AT_ONCE(scan), "scan_at_once")
extern const binding scan_bindings[];

// The kernel that writes the sums.
#define SCAN_LAST(scan) ((scan)->at_once ? (scan)->at_once : (scan)->blocks)

void scan_close(scan *s);

// Writes to each of n words the sum of the values before its own; `to` may be the values
// themselves. Kernels built with EMPTIES do not allow that, and set the values to zero.
bool scan_run(scan *s, timeline *t, const char *stage, const buffer *values, const buffer *to,
              uint32_t n, duet_error *err);

#endif
