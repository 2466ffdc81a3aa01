// SPDX-License-Identifier: MIT
// Follows drifting times while frames go by: which share the next frame takes.
//
// A few frames say what to expect; then both the frame's time and the balance
// of the two devices are watched. Once either has shifted, some frames move
// the share in small steps, and the best of them is kept.
#ifndef TUNER_ONLINE_H
#define TUNER_ONLINE_H

#include "tuner/drift.h"
#include "tuner/duet_tune.h"
#include "tuner/search.h"

enum { ONLINE_SETTLE = 31, ONLINE_MOVES = 16 };

typedef enum online_state {
    ONLINE_SETTLING, // learns what to expect
    ONLINE_WATCHING,
    ONLINE_MOVING // tries other shares
} online_state;

typedef struct online {
    uint32_t share;    // that is kept
    double most_extra; // a frame may be expected to take so much longer for a trial
    online_state state;
    search_sample seen[ONLINE_SETTLE];
    uint32_t n_seen;
    double total_ns; // expected
    double balance;  // expected time of A by that of B
    drift drifts[2];
    search search;
    uint32_t tunings; // so often it moved
} online;

online online_begin(uint32_t share, double most_extra);
void online_end(online *o);

// The share for the next frame.
bool online_share(const online *o, uint32_t *share, duet_error *err);

// What the frame took.
bool online_tell(online *o, const search_sample *frame, duet_error *err);

#endif
