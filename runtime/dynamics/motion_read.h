// SPDX-License-Identifier: MIT
// What was told of the bodies that moved.
#ifndef RUNTIME_MOTION_READ_H
#define RUNTIME_MOTION_READ_H

#include "runtime/opencl/program.h"

typedef struct motion_reading {
    kernel *gather_rows, *changed_rows; // NULL until something is read
    bool begun;                         // the device has what was read last
    uint32_t n;
    uint32_t *ids; // [n] that moved
    duet_state *states;
} motion_reading;

void motion_free_reading(motion_reading *r);

#endif
