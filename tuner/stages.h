// SPDX-License-Identifier: MIT
// The stages of a tuning, in their order. Each leaves what it found in the tuning.
#ifndef TUNER_STAGES_H
#define TUNER_STAGES_H

#include "tuner/tuning.h"

// Chooses how much of the work launches do, if all of it takes long and the machine can do a part:
// so little that twice as much is hardly quicker for each item. Rates are compared from then on.
void parts_choose(tuning *t);

// Measures the plans that were chosen on all of the work, once or a few times: the outcome has
// these times. If they contradict the verdict, it is reached once more, on all of the work.
void parts_finish(tuning *t);

// Chooses each device's variant, in races of its own: leaves in the tuning's plan the fastest
// variants, or the first ones if there is nothing to choose from.
void variants_choose(tuning *t);

// Finds the share that A does in the time that B needs for all the work: A's variants are compared
// there without an expensive launch.
uint32_t variants_share_of_a(tuning *t);

// Searches the kernels of B doing all the work, then the kernels of A doing as much as A does
// meanwhile. Kernels that are faster for sure enter the tuning's plan; the outcome says of each
// device what was tried. Does nothing unless a search is asked for; NOT_FOUND if it is for a kernel
// that neither device runs.
void kernel_tuning_run(tuning *t);

// Whether a tuning with that option `search` varies the kernel.
bool kernel_tuning_is_meant(const char *what, const kernel_space *space);

// Searches the best share of each mode, from the share that was best in the mode before; before
// that the kernels. Or, if the tuning's strategy chooses kernels and share together, measures plans
// until the strategy or the budget ends, and races the best few: the winner's kernels enter the
// tuning's plan, and the outcome says how many plans there are and were tried. The mode is then the
// first of those that may be chosen.
void plan_search_run(tuning *t);

// Races the best plan found against the better single device. A plan that does not prove
// faster is not used, so that a tuned world is never slower than one device.
//
// First all rivals race, for the better single device and the best shared plan.
// Then these two run against each other, and only that counts: a plan that was chosen as the
// best of several looks better in those samples than it is.
//
// A round is short, so that a slow while of the machine falls on all rivals
// alike. Another program that takes a core for a moment disturbs a plan for two devices twice
// as often as one for a single device; so the quicker of two launches counts.
void verdict_reach(tuning *t);

// Races the plan against the undivided device that A and B are parts of: two parts are worth
// opening only if they are not slower. Leaves the outcome if there is no such device or the
// budget ends.
void verdict_race_whole(tuning *t);

#endif
