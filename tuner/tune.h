// SPDX-License-Identifier: MIT
// One tuning: what is measured next, until it is known how to share the work.
//
// It is given what to choose from, a machine that measures plans, and functions that keep what was
// measured; it knows nothing else of devices and the store.
#ifndef TUNER_TUNE_H
#define TUNER_TUNE_H

#include "tuner/measure.h"

typedef struct tune_recorder {
    void *context;
    // Keeps the trial of that number; what was kept from that number on is stale. NULL: nothing is
    // kept.
    bool (*trial)(void *context, uint32_t number, const measurement *m, duet_error *err);
} tune_recorder;

// The one device that both devices are parts of.
typedef struct tune_whole {
    void *context;
    // Asked once a winner is known, whose kernels it runs. false: it is not raced.
    bool (*open)(void *context, const char *kernels, measure_machine *machine, duet_plan *plan);
} tune_whole;

typedef struct tune_problem {
    const duet_tune_def *def; // the choices, budget, strategy and watch
    measure_machine machine;
    energy_meter *meter; // energy is made small, which this reads; NULL: time is
    tune_recorder recorder;
    tune_whole whole;               // open NULL: there is none
    bool one_device;                // both are the same: there is nothing to share
    char searched[2][DUET_VARIANT]; // by device, what a search led to before; empty: none did
    duet_plan plan;                 // its variants are the defaults that must work
    uint32_t start;                 // a share that is likely near the best; 0: none is known
    uint32_t fair;                  // by units, of devices of one kind; 0: none
    duet_mode fair_mode;  // with `fair`: another share, mode or variant must be proven faster
    void *script;         // the strategy "lua" runs it
    uint32_t least_share; // shares nearer than this are the same
} tune_problem;

// The variants to choose from, in order: those that are asked for, or else ours. NULL
// past the end.
const char *tune_variant(const duet_tune_def *def, uint32_t i);
uint32_t tune_count_variants(const duet_tune_def *def);
bool tune_has_variant(const duet_tune_def *def, const char *variant);

// Modes that may be searched; some fit no pair of variants.
uint32_t tune_count_modes(const duet_tune_def *def);

// The share of about one work-group of n objects.
uint32_t tune_least_share(uint64_t n);

// A plan's variant by device; A is 0.
const char *plan_variant(const duet_plan *plan, int device);
char *plan_variant_of(duet_plan *plan, int device); // [DUET_VARIANT], to be written
void plan_set_variant(duet_plan *plan, int device, const char *variant);
void plan_set_variants(duet_plan *plan, const char *variant); // both

// state is empty, or an interrupted tuning's. After INTERRUPTED, and if the tuning gave up because
// of other programs, it can be handed in again. Fills all of outcome but known, resumed and
// objects.
bool tune_run(const tune_problem *problem, trial_log *state, duet_tune_outcome *outcome,
              duet_error *err);

// Whether the tuning gave up: nothing is known of its plan.
bool tune_gave_up(const duet_tune_outcome *outcome);

#endif
