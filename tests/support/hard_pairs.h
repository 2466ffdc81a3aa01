// SPDX-License-Identifier: MIT
// Pairs of boxes on which collision tests go wrong: touching, an ulp apart or
// into each other, nearly parallel, far, thin, tiny, huge. The same seed gives
// the same pairs on every machine.
#ifndef TESTS_HARD_PAIRS_H
#define TESTS_HARD_PAIRS_H

#include "base/rng.h"
#include "runtime/duet.h"

typedef struct hard_pair {
    duet_pose a, b;
} hard_pair;

typedef struct hard_class {
    const char *name;
    hard_pair (*make)(rng *r, uint32_t dims);
    bool touching; // every pair shares a point, by construction
} hard_class;

extern const hard_class hard_classes[]; // ends with a NULL name

duet_pose random_box(rng *r, double spread); // an ordinary one

// Prints a pair as C and as a row of a file for `duet query`, so that a failure can
// be repeated.
void hard_pair_print(const hard_pair *pair, uint32_t dims);

#endif
