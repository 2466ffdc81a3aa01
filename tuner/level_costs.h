// SPDX-License-Identifier: MIT
// What each level of accuracy costs on each device of a pair, and what it gets
// wrong on the same objects; and the level that follows from it.
#ifndef TUNER_LEVEL_COSTS_H
#define TUNER_LEVEL_COSTS_H

#include "base/core_watch.h"
#include "profiles/level_cost.h"
#include "profiles/profile.h"
#include "tuner/duet_tune.h"

enum { LEVEL_COSTS_ROUNDS = 100, LEVEL_COSTS_BOTH = 2 };

typedef struct level_cost {
    duet_level level;
    int device; // 0: A, 1: B, or the only one, each alone; LEVEL_COSTS_BOTH: by the default plan
    double step_ms;                     // the median
    double relative;                    // to sat15 there, the median by round
    double relative_low, relative_high; // its 95 % interval; 0 and infinity for few rounds
    bool same; // it takes as long as sat15 there, as far as these rounds show: the interval holds 1
    uint64_t pairs;
    uint64_t candidates;
    uint64_t undecided;    // by float, left to the host
    uint64_t missed;       // that collide
    uint64_t added;        // that do not
    double deepest_missed; // how deep the worst of those missed, the objects' unit
    double widest_added;   // how far apart the worst of those added
    bool front;            // nothing there is both faster, beyond noise, and more right
} level_cost;

typedef struct level_costs {
    level_cost rows[2 * DUET_LEVELS]; // by device, the cheapest to compute first
    uint32_t n;
    uint64_t truth;   // pairs that collide
    uint32_t rounds;  // that were timed
    core_tally cores; // other programs' use of the cores meanwhile
} level_costs;

typedef struct level_costs_def {
    duet_device_pair *pair;
    const duet_scene *scene;
    bool alone; // each device alone; else both by the default plan
    uint32_t rounds;
    duet_tune_watch *watch; // told after each step; false ends it with the whole rounds until then
    void *watch_context;
} level_costs_def;

// Steps the scene at each level once a round, so that whatever disturbs one disturbs all. Devices
// without double have no row for it. INTERRUPTED if there is no whole round.
bool level_costs_measure(level_costs *p, const level_costs_def *def, duet_error *err);

// Chooses the level with the quickest step among those of `levels` that were measured to be within
// accuracy. A level that promises all that it does, and takes at most 2 % longer, comes before it.
// NOT_FOUND if none is within accuracy, with the nearest.
bool level_choose(const profile_level_cost *costs, uint32_t n_costs, const duet_level *levels,
                  uint32_t n_levels, const duet_accuracy *accuracy, duet_level *level,
                  duet_error *err);

#endif
