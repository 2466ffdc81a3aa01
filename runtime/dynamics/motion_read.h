// SPDX-License-Identifier: MIT
// Rows of a motion's state that B gathers for the caller, and what was told of those that changed.
#ifndef RUNTIME_MOTION_READ_H
#define RUNTIME_MOTION_READ_H

#include "runtime/opencl/buffer.h"
#include "runtime/opencl/program.h"

typedef struct motion_reading {
    kernel *gather_rows, *changed_rows; // NULL until something is read
    uint32_t n_told; // bodies of which the device has what was read last; 0: all are to be told
    uint32_t n;
    uint32_t *ids; // [n] that moved
    duet_state *states;
    kernel *pack_rows, *unpack_rows, *move_rows; // likewise, a domain's (domain_rows.c)
    // other arguments of a launch
    buffer rows, last_rows; // a state's, by object
    buffer row_ids;         // a domain's lists of places, from first_id on
    cl_uint row_words, n_ids, first_id;
    cl_int4 row_parts;
    cl_uint of_four;
} motion_reading;

void motion_forget_moved(motion_reading *r);

#endif
