// SPDX-License-Identifier: MIT
// An ordered pair of devices, and where kernels and built programs are kept.
#ifndef RUNTIME_DEVICE_PAIR_H
#define RUNTIME_DEVICE_PAIR_H

#include "runtime/opencl/device.h"

#include <stdatomic.h>

struct duet_device_pair {
    atomic_uint users; // who opened it, and what was made on it
    device devices[2]; // A, B
    char *kernel_dir;  // NULL: the carried kernels
    char *cache_dir;   // NULL: no cache of ours
    program_builder builder;
};

// One user more, until it closes the pair.
void device_pair_hold(duet_device_pair *pair);

#endif
