// SPDX-License-Identifier: MIT
// What the searches found, against one device alone.
#ifndef TUNER_VERDICT_H
#define TUNER_VERDICT_H

#include "tuner/tuning.h"

// What the search of one mode came to.
typedef struct found {
    duet_mode mode;
    bool usable;
    uint32_t share;
    double a_alone_ns; // expected; INFINITY where nothing was seen of A
    double b_alone_ns; // as measured first
} found;

// The best of what was found, raced against the better single device. What does
// not prove to be faster is not used: tuned is never slower than one device.
bool verdict_reach(tuning *t, const found *founds, uint32_t n, duet_tune_outcome *outcome,
                   duet_error *err);

#endif
