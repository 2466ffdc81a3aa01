// SPDX-License-Identifier: MIT
// Tells where the time of this rank's steps goes, by phases: each lasts until the next one is
// entered.
#ifndef CLUSTER_MOVING_PHASES_H
#define CLUSTER_MOVING_PHASES_H

#include <stdint.h>

typedef enum moving_phase {
    PHASE_MANIFOLDS, // pairs, rows and manifolds
    PHASE_SLEEP,
    PHASE_COLOURS, // that a domain's own contacts decide
    PHASE_WAITING, // those of contacts that wait for other domains'
    PHASE_CLOSURE, // which contacts of ghosts are solved here, and what comes when
    PHASE_LISTS,   // contacts by colour
    PHASE_SUBSTEPS,
    PHASE_FINALIZE,
    // Bodies, contacts and ghosts are exchanged between domains:
    PHASE_LEAVE,   // those that leave are found and read
    PHASE_TRAVEL,  // they go, and ghosts are chosen
    PHASE_REPLACE, // motions get what came
    PHASE_SHARE,   // places of ghosts are told, and contacts of two ghosts come
    PHASE_NONE,    // between steps
    MOVING_PHASES = PHASE_NONE
} moving_phase;

// The cost of one phase, or of all so far.
typedef struct phase_cost {
    double ms, wait_ms; // by the clock, and of that for other ranks
    uint64_t launches;  // kernels
    uint64_t waits;     // of the host for its devices
    uint64_t exchanges; // messages to and from other ranks, and agreements, that it waited for
    uint64_t bytes;     // sent to other ranks
} phase_cost;

typedef struct moving_phases {
    moving_phase now;
    phase_cost begun; // all that had been when it was entered
    phase_cost costs[MOVING_PHASES + 1];
    uint64_t n_moves; // exchanges of bodies
} moving_phases;

struct moving;

// Forgets what phases took so far: as kernels were built, or bodies were brought. Ends the phase
// that was, and begins another.
void moving_begin_phases(struct moving *m);
void moving_enter(struct moving *m, moving_phase phase);

const char *moving_phase_name(moving_phase phase);

#endif
