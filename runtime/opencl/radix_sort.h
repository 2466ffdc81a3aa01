// SPDX-License-Identifier: MIT
// A stable sort of ids by their keys on a device: the host's side of
// kernels/primitives/radix.cl.
#ifndef RUNTIME_RADIX_SORT_H
#define RUNTIME_RADIX_SORT_H

#include "runtime/opencl/scan.h"

typedef struct radix_sort {
    const device *device;
    kernel *count, *move;
    scan *scan;
    buffer tiles; // [digits][n_tiles]
    buffer keys_in, ids_in, keys_out, ids_out;
    cl_uint n, shift, first_pass;
} radix_sort;

// The sorted arrays, each [n] words: keys, and buffers to write to in turn.
typedef struct radix_lists {
    buffer *keys, *ids;
    buffer *keys_spare, *ids_spare;
} radix_lists;

// The rows of its kernels in its owner's list; the owner also names the device and the scan, which
// outlive it.
#define RADIX_SORT_KERNELS(sort, wanted)                              \
    {&(sort)->count, wanted, "radix", "radix_count", radix_bindings}, \
    {                                                                 \
        &(sort)->move, wanted, "radix", "radix_move", radix_bindings  \
    }
extern const binding radix_bindings[];

void radix_sort_close(radix_sort *r);

// Sorts the keys by their lowest bits, and writes to ids where each was. The result is in
// keys and ids, which swap with their spares.
bool radix_sort_run(radix_sort *r, timeline *t, const char *stage, const radix_lists *lists,
                    uint32_t n, uint32_t bits, duet_error *err);

// The same, but sorts the given ids along with their keys.
bool radix_sort_ids(radix_sort *r, timeline *t, const char *stage, const radix_lists *lists,
                    uint32_t n, uint32_t bits, duet_error *err);

#endif
