// SPDX-License-Identifier: MIT
// Follows drifting times while frames go by: which share the next frame takes.
//
// A few frames say what to expect; then both the frame's time and the balance
// of the two devices are watched. Once either has shifted, some frames move
// the share in small steps, and the best of them is kept.
#ifndef TUNER_ONLINE_H
#define TUNER_ONLINE_H

#include "tuner/duet_tune.h"
#include "tuner/search.h"

// Whether steps take other times than expected: EWMA and CUSUM of the log of
// measured by expected time.
typedef struct drift {
    uint64_t n;
    double mean;     // EWMA of ln(measured / expected)
    double variance; // EWMA of its square about the mean
    double up;       // CUSUM, in standard deviations
    double down;
} drift;

// Adds one step. True where the times have shifted: the caller tunes again and
// starts from a zeroed drift. Allocates nothing.
bool drift_update(drift *d, double measured_ns, double expected_ns);

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
