// SPDX-License-Identifier: MIT
// A motion's bodies at a time, by place, and its ground, as pictures and frames show them.
#ifndef CLI_BODY_STATES_H
#define CLI_BODY_STATES_H

#include "runtime/duet.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct body_states {
    uint32_t n;
    duet_state *states;      // [n]
    duet_rounded_box *boxes; // [n] for their sizes
    uint64_t *ids;           // [n] DUET_NO_BODY: nothing is there
    uint8_t *asleep;         // [n] as duet_motion_get_asleep gives it; NULL: not read
    duet_motion_def def;     // its mesh is where it is
    duet_mesh carried;       // that mesh, if a body carries it
} body_states;

// Call body_states_free whatever this returns.
bool body_states_read(body_states *b, duet_motion *motion, duet_error *err);
bool body_states_read_asleep(body_states *b, duet_motion *motion, duet_error *err);
void body_states_free(body_states *b);

bool body_states_has(const body_states *b, uint32_t place);
uint32_t body_states_count(const body_states *b); // places that have a body

#endif
