// SPDX-License-Identifier: MIT
// Pair queries: the narrow phase alone, for pairs that the caller brings.
#ifndef DUET_PAIR_QUERY_H
#define DUET_PAIR_QUERY_H

#include "duet_device.h"
#include "duet_level.h"
#include "duet_object.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// Tests the caller's pairs as a step tests its candidates, on a device pair, again and again.
typedef struct duet_pair_query duet_pair_query;

typedef struct duet_pair_query_def {
    duet_device_pair *pair; // held until the query is destroyed
    uint32_t share;         // A's part of the pairs, out of DUET_SHARE_ONE; 0: B alone
    duet_level level;       // accuracy
    uint32_t dims;          // 2 or 3
    int cookie;
} duet_pair_query_def;

DUET_API duet_pair_query_def duet_default_pair_query_def(void);

typedef struct duet_pair_query_result {
    uint64_t colliding;
    uint64_t undecided;  // pairs that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // time of each device's part
} duet_pair_query_result;

// Creates a query and builds its kernels.
DUET_API duet_pair_query *duet_pair_query_create(const duet_pair_query_def *def, duet_error *err);
DUET_API void duet_pair_query_destroy(duet_pair_query *test);

// Tests n pairs; pair i is poses[2 i] and poses[2 i + 1].
//
//   answers     [n] 0 separated, 1 colliding; the same for (a, b) and (b, a)
//   separations [n] duet_poses_separation of each, on the host; NULL: not wanted
//
// An answer depends on its two poses alone, as if both were rotated. BAD_OBJECT
// names the first pair with a pose that is NaN, infinite, negative or without
// rotation; do not use answers and separations then.
DUET_API bool duet_pair_query_run(duet_pair_query *test, const duet_pose *poses, uint64_t n,
                                  uint8_t *answers, double *separations,
                                  duet_pair_query_result *result, duet_error *err);

DUET_C_END

#endif
