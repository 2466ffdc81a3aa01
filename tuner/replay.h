// SPDX-License-Identifier: MIT
// Tunings without a device: their launches are drawn from those that a store keeps.
//
// A launch of a plan is one of that plan's recorded launches. Between two recorded shares, at
// both of which both devices work, it is interpolated between the launches of equal rank: each
// device's time, and what the step takes beyond the slower one. One device alone takes no part in
// that, because its step lacks what sharing costs: below the least shared share, above the
// greatest one, and in gaps of more than 1/16 the nearest share stands for the one that was asked.
// On a joint surface a plan needs its own variants; one that was not recorded does not run.
#ifndef TUNER_REPLAY_H
#define TUNER_REPLAY_H

#include "base/rng.h"
#include "gen/script.h"
#include "profiles/surface.h"
#include "tuner/measure.h"
#include "tuner/recorded_space.h"

enum { REPLAY_MODES = DUET_MODE_DEFAULT };

// The launches of one plan, each list by total_ns: those that count, and those that warmed up.
typedef struct replay_point {
    duet_plan plan;
    const profile_launch *launches[2];
    uint32_t n[2]; // the first is not 0
    double median_ns;
} replay_point;

typedef struct replay {
    const profile_surface *surface; // borrowed
    profile_launch *launches;
    replay_point *points; // by mode and share
    uint32_t n_points;
    duet_mode modes[REPLAY_MODES]; // in which both devices worked
    uint32_t n_modes;
    const replay_point *best; // with the least median
    recorded_space *spaces;   // A's and B's, of a joint surface
    rng random;
    uint64_t spent_ns; // by the launches that were drawn
} replay;

// Reads a surface; r is closed by replay_close whatever this returns.
bool replay_open(replay *r, store *s, const profile_surface *surface, duet_error *err);
void replay_close(replay *r);

// The median of a plan's launches, which may be interpolated.
double replay_median_ns(const replay *r, const duet_plan *plan);

// The time of all launches until a trial showed that its plan is the best so far, and that plan's
// median time.
typedef struct replay_gain {
    double seconds;
    double median_ns;
} replay_gain;

enum { REPLAY_GAINS = 64 };

typedef struct replay_outcome {
    duet_plan plan; // to use
    char verdict[16];
    double median_ns;         // the plan's median time
    double loss;              // 0.02: the plan takes 2 % longer than the best recorded one; below
                              // 0: less, which only an interpolated plan can
    uint32_t search_launches; // until the last search of a share ended
    uint32_t launches;        // with the races after it
    double seconds;           // the time of all launches; kernels are not compiled
    replay_gain gains[REPLAY_GAINS];
    uint32_t n_gains;
} replay_outcome;

// Tunes mode and share, or kernels and share on a joint surface, as duet_tune_run does with a def
// of that strategy, seed and repeats; own is the script of the strategy "lua", else NULL. A
// strategy for the other kind of surface is BAD_ARGUMENT. The same seed gives the same outcome.
bool replay_run(replay *r, const duet_tune_def *def, script *own, replay_outcome *outcome,
                duet_error *err);

#endif
