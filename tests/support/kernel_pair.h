// SPDX-License-Identifier: MIT
// Two devices that are only arithmetic, and a kernel with two parameters on each: how long it takes
// by each of its configs is invented.
#ifndef SUPPORT_KERNEL_PAIR_H
#define SUPPORT_KERNEL_PAIR_H

#include "base/rng.h"
#include "gen/script.h"
#include "tuner/record.h"

enum {
    KERNEL_PAIR_SIZES = 4,
    KERNEL_PAIR_TILES = 3,
    KERNEL_PAIR_CONFIGS = KERNEL_PAIR_SIZES * KERNEL_PAIR_TILES,
    KERNEL_PAIR_POINTS = 16 // of the grid of shares
};

// A takes `slower` times as long as B; a config takes its factor times as long as the best one.
typedef struct kernel_pair {
    kernel_space space; // of both devices
    double factor[2][KERNEL_PAIR_CONFIGS];
    double
        crowded[KERNEL_PAIR_CONFIGS]; // and so much longer, as part of it, while both devices work
    double slower;
    double sigma;
    double unit_ns; // of a launch that takes 1
    bool waits;     // each launch for a core
    rng random;
    uint32_t launches, stop_after;
    uint32_t most_trials; // 0: any number
    uint32_t repeats;     // of a trial; 0: one
    record *record;       // that keeps the trials; NULL: none does
} kernel_pair;

// Draws what each config takes on each device, and how much slower A is.
void kernel_pair_invent(kernel_pair *f);

// Makes both devices alike, as those of one kind are.
void kernel_pair_equal(kernel_pair *f);

// A device's time for its part, and that of a launch, of units of one.
double kernel_pair_time_of_a(const kernel_pair *f, double share, uint32_t config);
double kernel_pair_time_of_b(const kernel_pair *f, double share, uint32_t config);
double kernel_pair_time(const kernel_pair *f, double share, uint32_t a, uint32_t b);
double kernel_pair_time_of_plan(const kernel_pair *f, const duet_plan *plan);
double kernel_pair_least_time(const kernel_pair *f); // of all plans of the grid

// How many plans the grid has.
uint32_t kernel_pair_plans(const kernel_pair *f);

// The config by which device B is the quickest.
uint32_t kernel_pair_best(const kernel_pair *f);

// The config that a variant's text sets.
uint32_t kernel_pair_config(const kernel_pair *f, const char *variant);

// own: the script of the strategy "lua", else NULL.
bool kernel_pair_tune(kernel_pair *f, const char *name, script *own, trial_log *log,
                      duet_tune_outcome *outcome, duet_error *err);

#endif
