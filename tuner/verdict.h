// SPDX-License-Identifier: MIT
// The verdict: what was found against one device alone, and against the undivided
// device.
//
// First all rivals race, for the better single device and the best shared plan.
// Then these two run against each other, and only that counts: samples from
// which the best of several was chosen make it look better than it is.
//
// A round is short, so that a slow while of the machine falls on all rivals
// alike. What takes a core away for a moment hits two of them twice as often as
// one: the quicker of two launches counts.
#ifndef TUNER_VERDICT_H
#define TUNER_VERDICT_H

#include "tuner/mode_search.h"

// The best of what was found, raced against the better single device. What does
// not prove to be faster is not used: tuned is never slower than one device.
bool verdict_reach(tuning *t, const mode_found *founds, uint32_t n, duet_tune_outcome *outcome,
                   duet_error *err);

// Two parts of a device are worth opening only where they are not slower than all
// of it. Leaves the outcome as it is where there is no such device or the budget ends.
bool verdict_race_whole(tuning *t, duet_tune_outcome *outcome, duet_error *err);

#endif
