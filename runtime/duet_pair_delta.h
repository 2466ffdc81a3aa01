// SPDX-License-Identifier: MIT
// Which pairs of a still world began and ended between two steps.
#ifndef DUET_PAIR_DELTA_H
#define DUET_PAIR_DELTA_H

#include "duet_motion.h"

DUET_C_BEGIN

// The pairs of the last step.
typedef struct duet_pair_delta duet_pair_delta;

// Ascending by a and b, the delta's until its next call. A pair that is told begins where it
// was not in the step before, and ends where it was and is no longer; those in both stay.
typedef struct duet_pair_delta_result {
    const duet_event *events;
    uint64_t n_events;
    const duet_pair *stays;
    uint64_t n_stays;
} duet_pair_delta_result;

DUET_API duet_pair_delta *duet_pair_delta_create(duet_error *err); // before it there was no pair
DUET_API void duet_pair_delta_destroy(duet_pair_delta *delta);

// Compares the pairs of both spans, those of a duet_result say, with those of the last call.
// Their order, and which device found them, do not count. After a failure the delta is as
// before.
DUET_API bool duet_pair_delta_update(duet_pair_delta *delta, const duet_span spans[2],
                                     duet_pair_delta_result *result, duet_error *err);

DUET_C_END

#endif
