// SPDX-License-Identifier: MIT
// Pair deltas: which pairs of a still world began and ended between two steps.
#ifndef DUET_PAIR_DELTA_H
#define DUET_PAIR_DELTA_H

#include "duet_motion.h"

DUET_C_BEGIN

// The pairs of the last step.
typedef struct duet_pair_delta duet_pair_delta;

// Ascending by a and b, the delta's until its next call. A pair begins if the step before did
// not have it, ends if only the step before had it, and stays if both have it.
typedef struct duet_pair_delta_result {
    const duet_event *events;
    uint64_t n_events;
    const duet_pair *stays;
    uint64_t n_stays;
} duet_pair_delta_result;

DUET_API duet_pair_delta *duet_pair_delta_create(duet_error *err); // without pairs
DUET_API void duet_pair_delta_destroy(duet_pair_delta *delta);

// Compares the pairs of both spans, such as a duet_result's, with those of the last call.
// Their order and device do not count. After a failure the delta is as before.
DUET_API bool duet_pair_delta_update(duet_pair_delta *delta, const duet_span spans[2],
                                     duet_pair_delta_result *result, duet_error *err);

DUET_C_END

#endif
