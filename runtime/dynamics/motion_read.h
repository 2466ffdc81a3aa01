// SPDX-License-Identifier: MIT
// Contacts and states of a motion, for callers to read. B gathers rows of some bodies for that, and
// what was told of those that changed is kept.
#ifndef RUNTIME_MOTION_READ_H
#define RUNTIME_MOTION_READ_H

#include "runtime/duet.h"
#include "runtime/opencl/buffer.h"

typedef struct motion_reading {
    uint32_t n_told; // bodies of which the device has what was read last; 0: all are to be told
    uint32_t n;
    uint32_t *ids; // [n] that moved
    duet_state *states;
    // other arguments of a launch
    buffer rows, last_rows; // a state's, by object
    buffer row_ids;         // a domain's lists of places, from first_id on
    cl_uint row_words, n_ids, first_id;
    cl_int4 row_parts;
    cl_uint of_four;
} motion_reading;

void motion_forget_moved(motion_reading *r);

// States of n bodies whose ids are valid, or without ids of the first n. If cells are asked for,
// centres are offsets in these.
bool motion_fetch_states(duet_motion *m, const uint32_t *ids, uint32_t n, duet_state *states,
                         cl_int4 *cells, duet_error *err);

// All states, which the caller frees; NULL if a number of them is no longer finite.
duet_state *motion_read_states(duet_motion *m, duet_error *err);

// Adds each body's state to a sum, by ascending place; false if a number of them is no longer
// finite.
typedef void (*add_state)(const duet_motion *m, uint32_t place, const duet_state *state, void *sum);
bool motion_sum_states(duet_motion *m, add_state add, void *sum, duet_error *err);

// Contacts of the manifolds that are right now, as duet_motion_get_contacts.
bool motion_read_contacts(duet_motion *m, duet_contact **contacts, uint64_t *n, duet_error *err);

#endif
