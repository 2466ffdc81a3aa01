// SPDX-License-Identifier: MIT
// What a level of accuracy promises, held against the exact answer.
#ifndef TESTS_PROMISE_H
#define TESTS_PROMISE_H

#include "support/hard_pairs.h"

// |t|_1 and all half extents.
double promise_size(const hard_pair *pair, uint32_t dims);

// Whether a level may give that answer for the pair: missed and added are the
// level's bounds, in units of that size.
bool promise_allows(double missed, double added, const hard_pair *pair, uint32_t dims, bool answer);

#endif
