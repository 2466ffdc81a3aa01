// SPDX-License-Identifier: MIT
// The space of a search that chooses both devices' kernels and the share together: a config for
// each kernel that a device varies, and a share of an even grid.
#ifndef TUNER_JOINT_SPACE_H
#define TUNER_JOINT_SPACE_H

#include "base/rng.h"
#include "runtime/broadphase/kernel_space.h"
#include "tuner/search.h"

typedef struct joint_space {
    kernel_spaces kernels; // A's, then B's
    uint32_t n_a;          // A's
    uint32_t points;       // intervals of the grid of shares; 0: B does all
    duet_plan base;        // with the texts of the variants that configs are added to
} joint_space;

// Adds a kernel of a device, A's before B's; beyond SEARCH_KERNELS of a device none.
bool joint_space_add(joint_space *s, int device, const kernel_space *kernel, duet_error *err);
void joint_space_free(joint_space *s);

// The configs that ran at first, at a share.
search_sample joint_space_base(const joint_space *s, uint32_t share);

// Gives a device without work the configs that ran at first: they are the same plan.
void joint_space_normalize(const joint_space *s, search_sample *p);

// How many plans the grid has, of at most 2^24 sets of configs of a device; and the one of a number
// below that. Plans that follow each other mostly differ in the share alone, whose change builds no
// kernel.
uint64_t joint_space_count(const joint_space *s);
search_sample joint_space_at(const joint_space *s, uint64_t number);

search_sample joint_space_random(const joint_space *s, rng *r);

// One step away: another value of one parameter of one kernel, or a share up to four steps of the
// grid away.
search_sample joint_space_neighbour(const joint_space *s, const search_sample *p, rng *r);

// False if a variant's text would be too long.
bool joint_space_plan(const joint_space *s, const search_sample *p, duet_plan *plan);

#endif
