// SPDX-License-Identifier: MIT
// Which level of accuracy a workload gets that says only how much may be wrong.
#ifndef TUNER_LEVEL_CHOICE_H
#define TUNER_LEVEL_CHOICE_H

#include "profiles/level_cost.h"
#include "runtime/duet.h"

// Of `levels` the one with the quickest step among those that were measured to
// be within accuracy. One that promises all that it does, and takes at most 2 %
// longer, comes before it. NOT_FOUND where none is within, with the nearest.
bool level_choose(const profile_level_cost *costs, uint32_t n_costs, const duet_level *levels,
                  uint32_t n_levels, const duet_accuracy *accuracy, duet_level *level,
                  duet_error *err);

#endif
