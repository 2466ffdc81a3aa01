// SPDX-License-Identifier: MIT
// Whether steps take other times than the profile says: EWMA and CUSUM of the
// log of measured by expected time.
#ifndef TUNER_DRIFT_H
#define TUNER_DRIFT_H

#include <stdbool.h>
#include <stdint.h>

typedef struct drift {
    uint64_t n;
    double mean;     // EWMA of ln(measured / expected)
    double variance; // EWMA of its square about the mean
    double up;       // CUSUM, in standard deviations
    double down;
} drift;

// Adds one step. True where the times have shifted: the caller tunes again and
// starts from a zeroed drift. Allocates nothing.
bool drift_update(drift *d, double measured_ns, double expected_ns);

#endif
