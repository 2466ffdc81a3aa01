// SPDX-License-Identifier: MIT
// The choice of each device's variant, in races of its own.
#ifndef TUNER_VARIANTS_H
#define TUNER_VARIANTS_H

#include "tuner/tuning.h"

// Leaves in the tuning's plan the fastest variants, or the first ones if there is nothing to choose
// from.
bool variants_choose(tuning *t, duet_error *err);

// Finds the share that A does in the time that B needs for all the work: A's variants are compared
// there without an expensive launch.
bool variants_share_of_a(tuning *t, uint32_t *share, duet_error *err);

#endif
