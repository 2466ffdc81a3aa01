// SPDX-License-Identifier: MIT
#ifndef TUNER_SUBJECT_STILL_H
#define TUNER_SUBJECT_STILL_H

#include "tuner/search_history.h"

#include "runtime/duet.h"

// A step's times as strategies want them: each device's from the step's begin.
search_sample measure_sample(const duet_result *result, const duet_plan *plan);

#endif
