// SPDX-License-Identifier: MIT
// Measures a plan: verified before any time counts, warmed up, every launch
// kept, with the terms of the paper's equations 4 to 6. A launch that other programs
// disturbed is repeated.
#ifndef TUNER_MEASURE_H
#define TUNER_MEASURE_H

#include "base/core_watch.h"
#include "base/energy_meter.h"
#include "profiles/session.h"
#include "runtime/broadphase/kernel_space.h"
#include "tuner/trial_log.h"

enum {
    MEASURE_REPEATS = 32,
    MEASURE_STAGES = 48,
    MEASURE_LAUNCHES = 2 * MEASURE_REPEATS + 5 // one to warm up, and those that are repeated
};

// Holds what one step of a machine took and found.
typedef struct measure_launch {
    int64_t total_ns;
    int64_t a_ns;
    int64_t b_ns;
    int64_t transfer_ns;
    uint64_t hash; // its result's hash
    core_use use;  // all zero: nothing is known of it
    duet_tune_terms terms;
    duet_stage stages[MEASURE_STAGES];
    uint32_t n_stages;
} measure_launch;

// A machine runs the plans to measure: a subject, or arithmetic in tests. staged: the times of the
// launch's stages are wanted, which makes a GPU's launch longer. If false, the launch is as
// applications have it, and a GPU's stages are the stages of the last staged launch.
typedef struct measure_machine {
    void *context;
    bool (*launch)(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                   duet_error *err);
    uint64_t hash; // the right result's hash
    // How many cores other programs have; NULL: none.
    core_others (*look_at_others)(void *context);
    // The plan so many times, of which only the last is checked; NULL: by `launch`.
    bool (*train)(void *context, const duet_plan *plan, uint32_t n, duet_error *err);
    // Adds the config spaces of the kernels that a device runs by a plan. Called only if kernels
    // are searched.
    bool (*read_kernels)(void *context, const duet_plan *plan, int device, kernel_spaces *to,
                         duet_error *err);
    // From now on launches do that part of each device's work, of DUET_SHARE_ONE, the first of it.
    // NULL: they do all.
    void (*set_part)(void *context, uint32_t part);
    double launch_ms; // that all of the work takes, about; 0: not known, and no part is done
} measure_machine;

typedef struct measurement {
    trial trial;        // but its time in focus; usable: the outcome is "ok"
    duet_error failure; // why the outcome is not "ok"
    profile_trial row;  // its outcome, and statistics of the samples that count
    profile_sample samples[MEASURE_LAUNCHES]; // the first is the warm-up, if there is one
    uint32_t n_samples;
    uint32_t counted;  // fewer than asked for: the others were disturbed, however often they were
                       // repeated
    uint32_t repeated; // disturbed launches that therefore do not count
    uint32_t typical;  // the sample with the median time, the lower one of two
    measure_launch launch; // that one, with the least that each stage took in any
} measurement;

// A measurement that is not staged stages only the warm-up launch, so that the launches that count
// are as applications have them; if its plan is warm, nothing is known of the stages.
typedef struct measure_way {
    uint32_t repeats;    // launches that count, at most MEASURE_REPEATS
    bool warm;           // the plan ran before, and no launch warms it up
    bool staged;         // the time of stages counts
    bool quiet;          // a launch that other programs disturbed is repeated and does not count
    energy_meter *meter; // what a launch takes is read from it, over launches of its own, and put
                         // into the terms; NULL: it is not
} measure_way;

// Runs one launch to warm up, unless the plan is warm, then `repeats`; all are verified. A plan
// that does not build, run or find the right pairs is a measurement whose outcome says so. If
// disturbed launches are repeated, there are at most twice as many and four more.
measurement measure_plan(const measure_machine *machine, const duet_plan *plan, measure_way way);

// Makes a trial of the plan again from what the store holds of it.
trial measure_recall(const duet_plan *plan, const profile_trial *row);

int64_t measure_to_ns(double ms);

// Begins to watch a launch by the pair, until core_watch_stop. Its work is spread over the units of
// the pair's CPUs, if one of these has several, which share the work as it comes; else each CPU is
// one thread, or there is none.
void measure_watch(core_watch *cores, const duet_device_pair *pair);

// Takes over a launch's stages, as many as there is space for, and sums transfers.
void measure_take_stages(measure_launch *launch, const duet_stage *stages, uint32_t n);

// The stage of that device and name; n if there is none yet.
uint32_t measure_find_stage(const duet_stage *stages, uint32_t n, const duet_stage *like);

// Returns the launch's time on a device in stages of these names; names end with NULL or after
// `most`.
uint64_t measure_stages_ns(const measure_launch *launch, int side, const char *const *names,
                           uint32_t most);

#endif
