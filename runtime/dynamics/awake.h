// SPDX-License-Identifier: MIT
// What a step may change: lists of bodies and contacts that leave out what sleeps and what never
// moves (products.h, kernels/dynamics/awake.cl). Without the effect sleep there are no lists, and
// all is listed.
#ifndef RUNTIME_AWAKE_H
#define RUNTIME_AWAKE_H

#include "kernels/dynamics/records.h"
#include "runtime/opencl/buffer.h"

// n_bodies and n_contacts are at least as many as there are in the lists: kernels are launched over
// so many, and ask the device for the number. With all_awake kernels go over all bodies and
// contacts, and the lists mean nothing: where they would have most bodies they cost more than they
// save.
typedef struct awake_lists {
    uint32_t n_bodies;
    cl_uint n_contacts;
    cl_uint all_awake;   // 0 or 1
    host_block counts;   // [LISTED] by the device, once a later read has waited
    uint64_t counted_in; // the step
    uint64_t changed_in; // the last step in which something woke or fell asleep, or a command
                         // altered bodies
    // what a launch is told besides
    cl_uint n_parts;
} awake_lists;

bool motion_make_awake(duet_motion *m, duet_error *err);

// Once flags were read: makes the lists again, with what woke in this step.
bool motion_list_woken(duet_motion *m, duet_error *err);

// Once flags were read, or all is over: takes the numbers that the device counted. At the end of a
// step: notes in the products whether the lists hold.
void motion_count_awake(duet_motion *m);
void motion_note_awake(duet_motion *m);

#endif
