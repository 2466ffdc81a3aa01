// SPDX-License-Identifier: MIT
// A tuning under way: runs trials within the budget, each from the log or else from the
// machine, and tells the recorder and the watcher.
//
// A tuning goes on until a trial, a search or somebody stops it. From then on it measures nothing:
// the stages run to their ends without trials, and tune_run tells why.
#ifndef TUNER_TUNING_H
#define TUNER_TUNING_H

#include "tuner/tune.h"

// The stages of a device whose kernel is varied. A plan that ran before is not warmed up again
// for them.
typedef struct focus {
    int device;
    const char *const *stages; // NULL: none
    uint32_t n;                // stages at most
} focus;

// Holds the result of the search of one mode.
typedef struct mode_found {
    duet_mode mode;
    bool usable;
    uint32_t share;
    double a_alone_ns; // expected; INFINITY if nothing was seen of A
    double b_alone_ns; // the first measured time of B alone
} mode_found;

enum { MOST_MODES = 8 };

typedef struct tuning {
    const tune_problem *problem;
    trial_log *state;
    duet_tune_outcome *outcome; // that the stages fill
    duet_error why;             // why it has stopped; OK: it goes on
    const char *stage;
    double stage_end; // part of the budget that is used up when it must end
    uint32_t repeats; // launches of a trial that count
    bool at_once;     // plans that ran before are not warmed up again, and a launch counts as it is
    double scatter;   // deviation of a launch, as part of it; INFINITY: not known
    uint32_t first;   // trial that this process measured
    uint32_t part;    // of each device's work that a launch does, of DUET_SHARE_ONE
    focus focus;
    duet_plan plan;  // the variants chosen so far
    duet_plan alone; // the better single device, once there is a verdict
    mode_found founds[MOST_MODES];
    uint32_t n_founds;      // modes that were searched; 0: there is nothing to share
    uint32_t search_begun;  // at this trial
    uint32_t search_trials; // about so many that the search of kernels takes; UINT32_MAX: not known
    uint32_t launches;
    uint64_t spent_ns;
    uint32_t watched; // launches whose threads were watched
    uint32_t disturbed;
    uint64_t waited_ns;   // waiting for other programs, disturbed trials included
    uint32_t quiet_tries; // to repeat trials that were disturbed beside no other program
    bool found;           // a kernel to be searched
    bool cut;             // the budget ended a search
    duet_error failure;   // the first plan's that did not run
} tuning;

// Whether the tuning has not stopped and the stage is within its part of the budget.
bool tuning_goes_on(const tuning *t);

// Adds the trial to the log. It stops the tuning if the budget can reach no verdict, the default
// variants find wrong pairs, the log cannot be kept, or somebody says so. The trial of a plan that
// does not run, or of a tuning that has stopped, is not usable. Its times are those of all the
// work, at the rate of the part that was done.
trial tuning_run_trial(tuning *t, const duet_plan *plan);

// How many launches of a trial are to count, by what the last trial's took: the usual number, or
// more if they scatter and are short, which cost least.
uint32_t tuning_count_launches(const tuning *t, uint32_t usual);

// The same on the undivided device; whole NULL: on the pair.
trial tuning_run_on(tuning *t, const measure_machine *whole, const duet_plan *plan);

// The tuning has waited for other programs as long as it may, and has stopped because of that.
bool tuning_is_out_of_patience(const tuning *t);

// Names the cores that other programs have: "1.4 of 2 cores".
typedef struct tuning_others {
    char chars[96];
} tuning_others;

tuning_others tuning_describe_others(const tuning *t);

// Stops it with INTERRUPTED, unless it has stopped; always false.
bool tuning_stop(tuning *t);

// The chosen variants at a share.
duet_plan tuning_plan(const tuning *t, uint32_t share, duet_mode mode);

#endif
