// SPDX-License-Identifier: MIT
// After how many colours ghosts come, if nobody says. No number changes a bit, so some are tried
// while the job takes its steps, once exchanges take a part of a step that is worth it.
#ifndef CLUSTER_MOVING_EVERY_H
#define CLUSTER_MOVING_EVERY_H

#include "cluster/ranks.h"

// After each colour, some, and all of them.
enum { EVERY_RIVALS = 3 };
extern const uint32_t every_rivals[EVERY_RIVALS];

typedef struct every_trial {
    bool is_given;                // by a plan, a profile or the caller: nothing is tried
    bool is_tried;                // each has its time
    uint32_t turn;                // of the trial under way, from 1; 0: none is
    uint64_t next;                // the step before which there is no other one
    uint64_t begun_ns;            // of this rank's step, as are
    uint64_t quickest_ns;         // exchange of ghosts
    uint32_t n_exchanges;         // of ghosts after colours
    uint32_t n_steps;             // of the turn, or since the last one, all ranks', as are
    double ns, latency_ns;        // that they took, and what exchanges take of that at least
    double best_ns[EVERY_RIVALS]; // a step of the quickest turn
} every_trial;

struct moving;

// Notes an exchange after a colour that took this rank so long.
void every_note_exchange(every_trial *t, uint64_t ns);

// Adds this rank's step to its agreement, and then takes that of all.
void every_note_step(struct moving *m, tally *t);
void every_take_step(struct moving *m, const tally *t);

// Before a step: goes on to another number if that is due. Collective; false as moving_settle.
bool every_choose(struct moving *m, duet_error *own);

#endif
