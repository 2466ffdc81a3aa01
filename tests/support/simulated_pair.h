// SPDX-License-Identifier: MIT
// A device pair that is only arithmetic: strategies run on it in microseconds.
//
// Times are an invented cost function's or a recorded table's, with noise and
// spikes where asked for, and the same for the same seed on every machine.
#ifndef SUPPORT_SIMULATED_PAIR_H
#define SUPPORT_SIMULATED_PAIR_H

#include "base/rng.h"
#include "tuner/strategy.h"

// One row of a recorded table, or a launch without noise.
typedef struct simulated_row {
    uint32_t share;
    uint64_t total_ns;
    uint64_t a_ns;
    uint64_t b_ns;
} simulated_row;

// Times are in units of B's time for the whole work, 10 ms.
typedef struct simulated_pair {
    double ratio;              // A is so many times slower than B
    double fixed[2];           // part of its time that does not shrink with its work
    double overhead[2];        // cost of taking part for each device when both do
    uint32_t waves[2];         // each device's work goes in so many equal steps; 0: smoothly
    double interference;       // each device is slower by this part while the other works
    double sigma;              // noise of each device's time, as a part of it
    double spike_chance;       // a launch's device time is disturbed with this chance
    double spike_most;         // and then takes up to so many times as long, at least 1.2
    const simulated_row *rows; // recorded instead of invented, ascending by share
    uint32_t n_rows;
} simulated_pair;

// Families of invented models; each draws a speed ratio of 1 to 64, even over
// its logarithm, and overheads of up to 15 % of the best total.
typedef enum simulated_family {
    SIMULATED_AFFINE,
    SIMULATED_STEPS,  // B in 8 to 32 waves, A in 16 to 64
    SIMULATED_INTERF, // each slows the other by up to 25 %
    SIMULATED_FIXED   // 20 to 60 % of each device's time is a grid that it builds in any case
} simulated_family;

// mirrored: A is the faster one. Without noise; set sigma and spikes after.
simulated_pair simulated_invent(simulated_family family, bool mirrored, rng *r);

// One launch at a share. rng NULL: without noise.
search_sample simulated_launch(const simulated_pair *model, uint32_t share, rng *r);

// The share with the least total without noise, and that total.
search_sample simulated_best(const simulated_pair *model);

// Asks and measures until the search is done. cost_ns, unless NULL, takes the
// sum of all totals.
bool simulated_run(search *s, const simulated_pair *model, rng *r, uint64_t *cost_ns,
                   duet_error *err);

// How much longer a share takes than the best one: 0.02 is 2 %.
double simulated_excess(const simulated_pair *model, uint32_t share);

#endif
