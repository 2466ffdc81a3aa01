// SPDX-License-Identifier: MIT
// The verdict: the plan that was found is raced against one device alone, and against the
// undivided device.
//
// First all rivals race, for the better single device and the best shared plan.
// Then these two run against each other, and only that counts: a plan that was chosen as the
// best of several looks better in those samples than it is.
//
// A round is short, so that a slow while of the machine falls on all rivals
// alike. Another program that takes a core for a moment disturbs a plan for two devices twice
// as often as one for a single device; so the quicker of two launches counts.
#ifndef TUNER_VERDICT_H
#define TUNER_VERDICT_H

#include "tuner/mode_search.h"

// Races the best plan found against the better single device. A plan that does not prove
// faster is not used, so that a tuned world is never slower than one device.
bool verdict_reach(tuning *t, const mode_found *founds, uint32_t n, duet_tune_outcome *outcome,
                   duet_error *err);

// Races the plan against the undivided device that A and B are parts of: two parts are worth
// opening only if they are not slower. Leaves the outcome if there is no such device or the
// budget ends.
bool verdict_race_whole(tuning *t, duet_tune_outcome *outcome, duet_error *err);

#endif
