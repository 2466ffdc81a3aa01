// SPDX-License-Identifier: MIT
// The search for the best share in each mode.
#ifndef TUNER_MODE_SEARCH_H
#define TUNER_MODE_SEARCH_H

#include "tuner/tuning.h"

enum { MOST_MODES = 8 };

// What the search of one mode came to.
typedef struct mode_found {
    duet_mode mode;
    bool usable;
    uint32_t share;
    double a_alone_ns; // expected; INFINITY where nothing was seen of A
    double b_alone_ns; // as measured first
} mode_found;

// Each mode is searched from the share that was best in the one before. *n modes were;
// none where there is nothing to share.
bool mode_search_run(tuning *t, mode_found founds[MOST_MODES], uint32_t *n, duet_error *err);

#endif
