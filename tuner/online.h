// SPDX-License-Identifier: MIT
// Follows drifting times while frames go by: which plan the next frame takes.
//
// A few frames say what to expect; then both the frame's time and the balance of the two devices
// are watched. When either has shifted, some frames move the share in small steps, and the best of
// them is kept. A plan of another mode, other kernels or the other number of devices is sounded now
// and then, for a few frames; if it promises to be faster, it races the one that is kept, and takes
// its place only with a verdict as a tuning's. No plan runs that is expected to make a frame longer
// than was allowed.
//
//   SETTLING -> WATCHING -> MOVING (times shifted, and both devices work) -> SETTLING
//               WATCHING -> RACING (three rounds, a rival's turn; twenty, if it is expected to be
//                           faster) -> WATCHING, or MOVING if it is
#ifndef TUNER_ONLINE_H
#define TUNER_ONLINE_H

#include "tuner/duet_tune.h"
#include "tuner/plan_times.h"
#include "tuner/race.h"
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

// Adds one step. Returns true if the times have shifted: the caller tunes again and starts from a
// zeroed drift. Allocates nothing.
bool drift_update(drift *d, double measured_ns, double expected_ns);

enum { ONLINE_SETTLE = 31, ONLINE_MOVES = 16 };

typedef enum online_state {
    ONLINE_SETTLING, // learns what to expect
    ONLINE_WATCHING,
    ONLINE_MOVING, // tries other shares
    ONLINE_RACING  // a rival and the plan that is kept take turns
} online_state;

typedef struct online_seen {
    search_sample frames[ONLINE_SETTLE];
    uint32_t n;
} online_seen;

typedef struct online {
    listed_plan plan;  // that is kept
    double most_extra; // a frame may be expected to take so much longer for a trial
    online_state state;
    plan_times times;    // that rivals are expected to take; without any there are no rivals
    online_seen seen[2]; // the kept plan's and the rival's
    double total_ns;     // expected
    double balance;      // expected time of A by that of B
    drift drifts[2];
    search search;
    listed_plan rival;
    race race;        // the plan is 0, the rival 1
    uint32_t last;    // plan that ran last, 0 or 1: the first frame after the other plan's warms
                      // up, and does not count
    uint32_t turn;    // the rival to sound next
    uint32_t rested;  // frames watched since a rival was last looked for
    uint32_t rest;    // frames until that is done again
    uint32_t tunings; // so often the share moved, or another plan was taken
} online;

online online_begin(const listed_plan *plan, double most_extra);
void online_end(online *o);

// The plan for the next frame.
bool online_plan(const online *o, listed_plan *plan, duet_error *err);

// Reports the times of the frame.
bool online_tell(online *o, const search_sample *frame, duet_error *err);

// Whether the next frame's plan is a rival's.
bool online_is_trial(const online *o);

// The rival cannot run. The plan that is kept is next.
void online_refuse(online *o);

#endif
