// SPDX-License-Identifier: MIT
// An ordered pair of devices, and where kernels and built programs are kept.
#ifndef RUNTIME_DEVICE_PAIR_H
#define RUNTIME_DEVICE_PAIR_H

#include "runtime/device.h"

struct duet_device_pair {
    device devices[2]; // A, B
    char *kernel_dir;  // NULL: the carried kernels
    char *cache_dir;   // NULL: no cache of ours
};

#endif
