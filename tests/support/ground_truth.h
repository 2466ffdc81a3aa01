// SPDX-License-Identifier: MIT
// Rays and points at a tree's ground, which has no objects but those that are said, against truths
// in long double.
#ifndef TESTS_GROUND_TRUTH_H
#define TESTS_GROUND_TRUTH_H

#include "support/real.h"

#include "base/rng.h"

enum { GROUND_ID = 6 }; // of a ground without objects: walls have 0 to 5

typedef struct ground_truth {
    const void *ground;
    real (*cast)(const void *ground, const duet_ray *ray); // INFINITY: it meets nothing
    real (*distance)(const void *ground, const real at[3]);
    bool is_solid;  // a ray may begin in it: then it has no normal
    double deepest; // rays and points are drawn from that height on
} ground_truth;

// Casts rays at random, upright and along axes among them, that meet the ground by half.
void ground_truth_check_rays(const ground_truth *t, duet_tree *tree, rng *r);

// Asks for the three nearest objects of points at random; the tree has one besides the ground.
void ground_truth_check_points(const ground_truth *t, duet_tree *tree, rng *r);

#endif
