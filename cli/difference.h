// SPDX-License-Identifier: MIT
// Finds what differs first between two motions after the same step: the stage, in that the body of
// the least id, its first field, and both values.
#ifndef CLI_DIFFERENCE_H
#define CLI_DIFFERENCE_H

#include "cli/verified_run.h"

typedef struct difference {
    const char *stage; // NULL: nothing differs
    uint64_t step;     // that both motions took; 0: their start
    uint64_t body;     // id, or DUET_NO_BODY: a number of all
    char field[64];    // "velocity.x"
    double values[2];  // NAN: that motion has none
} difference;

// Whether the two differ at all: number of places, hash, events, contacts that push. Before a step
// there are no events.
bool difference_is(const verified_run runs[2], bool stepped);

// Whether the events of a step, or its numbers of contacts that push, differ, which costs nothing.
bool difference_is_told(const verified_run runs[2]);

// Finds what differs after a step, in the order of its stages: contacts (which touch), manifolds
// (where), colours, solver (impulses, velocities and poses; integration if nothing pushes), events.
bool difference_find(difference *d, const verified_run runs[2], duet_error *err);

// Finds what of the states differs, before a step.
bool difference_find_state(difference *d, const verified_run runs[2], const char *stage,
                           duet_error *err);

// Adds "step 13, solver, body 37: velocity.x is 1 and 2".
void difference_tell(const difference *d, text *to);

#endif
