// SPDX-License-Identifier: MIT
// Which pairs touch, over all domains: a contact is told by one of them, that of an end
// (moving_other_tells). So what one rank tells is known to it alone, and all ranks together tell
// what one motion does.
#ifndef CLUSTER_MOVING_EVENTS_H
#define CLUSTER_MOVING_EVENTS_H

#include "runtime/dynamics/pair_list.h"

// The events of all this rank's domains, by global ids.
typedef struct moving_events {
    pair_list before, now; // told pairs that touch
    pair_changes changes;
    duet_hit_event *hits;
    size_t n_hits, capacity;
} moving_events;

struct moving;

void moving_events_end(moving_events *e);

// Notes what touches now, once bodies and contacts have changed domains.
void moving_note_touching(struct moving *m, duet_error *own);

// After a step, finds what touches now, what changed, and what hit.
void moving_find_events(struct moving *m, duet_error *own);

#endif
