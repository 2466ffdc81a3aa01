// SPDX-License-Identifier: MIT
// Which pairs touch, and what came of it in a step: begins, stays, ends and hits.
#ifndef RUNTIME_MOTION_EVENTS_H
#define RUNTIME_MOTION_EVENTS_H

#include "runtime/dynamics/pair_list.h"

// Words of a hit as kernels/dynamics/contact_events.cl writes it.
enum { HIT_WORDS = 16, HIT_CENTRE = 10 };

typedef struct motion_events {
    pair_list links;    // owner and other of each contact, as the device has them
    pair_list touching; // after the last step, ascending
    uint64_t links_of;  // the stamp of the rows that both are of; 0: forgotten
    pair_list before;   // the step before
    pair_changes changes;
    duet_hit_event *hits;
    size_t n_hits, hit_capacity;
} motion_events;

// Before a step: what touches, if a state was loaded.
bool motion_recall_events(duet_motion *m, duet_error *err);

// In a step, before anything is moved: sends for what touches and hits.
bool motion_note_events(duet_motion *m, duet_error *err);

// At its end, once the flags are read if anything moved.
bool motion_find_events(duet_motion *m, bool moved, duet_error *err);

// Pairs that touch are read again before the next step.
void motion_forget_events(motion_events *e);
void motion_free_events(motion_events *e);

#endif
