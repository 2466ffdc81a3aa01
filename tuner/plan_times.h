// SPDX-License-Identifier: MIT
// What each device takes for its part of a step, by mode and variant: straight lines over the part,
// from which the time of any plan can be expected before it runs.
//
// A device's lines rise and fall together with the one that is in use, because most of what slows
// a device down slows all of its kernels.
#ifndef TUNER_PLAN_TIMES_H
#define TUNER_PLAN_TIMES_H

#include "tuner/duet_tune.h"
#include "tuner/search.h"

#define PLAN_LEAST_SHARE (SEARCH_ONE / 64) // that can be measured

enum { PLAN_VARIANTS = 4, PLAN_MODES = 3, PLAN_ALONE = PLAN_MODES, PLAN_WAYS };

// A duet_plan whose variants are places in a list. A plan of one device has mode own.
typedef struct listed_plan {
    uint32_t share;
    uint32_t mode;       // a duet_mode
    uint32_t variant[2]; // A's, B's
} listed_plan;

// ns for a part: base + each * part. Both 0: not known.
typedef struct part_line {
    double base_ns;
    double each_ns;
} part_line;

typedef struct plan_times {
    uint32_t n_variants;
    double load[2];   // that the devices' lines have grown by since they were learned
    double switch_ns; // that the first frame with other kernels takes longer
    part_line lines[PLAN_WAYS][2]
                   [PLAN_VARIANTS]; // PLAN_ALONE: of the whole work, without a partner
} plan_times;

bool plan_is_shared(const listed_plan *plan);
bool plan_is_same(const listed_plan *a, const listed_plan *b); // or shares less than 1/64 apart

// Runs plans: a world, or arithmetic in tests. False: the plan cannot run.
typedef struct plan_runner {
    void *context;
    bool (*run)(void *context, const listed_plan *plan, search_sample *frame);
} plan_runner;

// Runs each variant alone and in each of the modes at two shares, four frames each. Mode shared
// needs equal kernels on both devices.
void plan_times_learn(plan_times *t, uint32_t n_variants, uint32_t modes,
                      const plan_runner *runner);

// The time that a device's part is expected to take; 0: it has none. INFINITY: not known.
double plan_times_expect_part(const plan_times *t, const listed_plan *plan, int device);

// Returns how much longer the first frame takes if plan `to` follows `from`; 0 if the kernels are
// the same.
double plan_times_switch(const plan_times *t, const listed_plan *from, const listed_plan *to);

// The time of a step by the plan.
double plan_times_expect(const plan_times *t, const listed_plan *plan);

// The largest part, of 1/64 to 63/64 out of SEARCH_ONE, for which the device is expected to take no
// longer, beside a partner.
uint32_t plan_times_largest_part(const plan_times *t, const listed_plan *plan, int device,
                                 double most_ns);

// Moves the plan's lines to what a frame took. all[device]: and all other lines of that device by
// as much.
void plan_times_follow(plan_times *t, const search_sample *frame, const listed_plan *plan,
                       const bool all[2]);

// Expects that a device of which nothing is seen has lost a fifth of its load, down to what was
// learned first.
void plan_times_recover(plan_times *t, int device);

// Forgets the plan's lines, because it cannot run.
void plan_times_forget(plan_times *t, const listed_plan *plan);

// The rival of that number; false past the last.
bool plan_times_rival(const plan_times *t, uint32_t i, listed_plan *rival);

#endif
