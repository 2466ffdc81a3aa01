// SPDX-License-Identifier: MIT
// The terms of the paper's equations 4 to 6, from the stages of a step.
#ifndef TUNER_TERMS_H
#define TUNER_TERMS_H

#include "runtime/base/text.h"
#include "tuner/duet_tune.h"

duet_tune_terms terms_of(const duet_result *result, const duet_plan *plan);

// {"T_1":..,"T_CPU1":..,...,"imbalance":..}, milliseconds.
void terms_to_json(const duet_tune_terms *terms, text *json);

#endif
