// SPDX-License-Identifier: MIT
// The stage in which a strategy chooses kernels and share together, in the place of a search of
// kernels and then of mode and share.
#ifndef TUNER_JOINT_SEARCH_H
#define TUNER_JOINT_SEARCH_H

#include "tuner/mode_search.h"

// Whether the tuning's strategy is such a one.
bool joint_search_is_asked(const tune_problem *problem);

// Measures plans until the strategy or the budget ends, and races the best few. The winner's
// kernels enter the tuning's plan, and found has its share; told gets how many plans there are and
// were tried. The mode is the first of those that may be chosen; *n is 1.
bool joint_search_run(tuning *t, mode_found *found, uint32_t *n, duet_tune_outcome *told,
                      duet_error *err);

#endif
