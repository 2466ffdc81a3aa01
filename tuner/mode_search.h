// SPDX-License-Identifier: MIT
// The search for the best share in each mode.
#ifndef TUNER_MODE_SEARCH_H
#define TUNER_MODE_SEARCH_H

#include "tuner/search.h"
#include "tuner/tuning.h"

enum { MOST_MODES = 8 };

// Holds the result of the search of one mode.
typedef struct mode_found {
    duet_mode mode;
    bool usable;
    uint32_t share;
    double a_alone_ns; // expected; INFINITY if nothing was seen of A
    double b_alone_ns; // the first measured time of B alone
} mode_found;

// Measures the plans that a strategy wants, until it or the budget ends. A strategy for the share
// ends at a plan that does not run, which usable says; others are told.
bool mode_search_ask(tuning *t, search *s, bool *usable, duet_error *err);

// Searches each mode from the share that was best in the mode before. *n modes were searched; none
// if there is nothing to share.
bool mode_search_run(tuning *t, mode_found founds[MOST_MODES], uint32_t *n, duet_error *err);

#endif
