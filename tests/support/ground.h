// SPDX-License-Identifier: MIT
// Bodies of all shapes over a ground of either kind.
#ifndef TESTS_GROUND_H
#define TESTS_GROUND_H

#include "support/mover.h"

#include "base/rng.h"

// A mover on which a ground is tested: gravity, a slop, contacts with response at any speed. One of
// both is NULL, or both: there is no ground.
mover *ground_mover(const duet_heights *heights, const duet_mesh *mesh);
extern const double ground_slop;

// Heights at places: level, a bowl, and at random from ground_drawn.
double ground_flat(double x, double y);
double ground_bowl(double x, double y);
double ground_rough(double x, double y);
extern rng ground_drawn;

// ---------------------------------------------------------------- bodies

typedef enum ground_kind {
    BALL,
    ROLLING_BALL,
    CAPSULE_ALONG,
    CAPSULE_ACROSS,
    ROUNDED,
    SHARP,
    GROUND_KINDS
} ground_kind;

// Adds a body that touches a level ground at height 0 below x, y.
uint32_t ground_add(mover *m, uint32_t kind, double x, double y);

// Adds a body over a square of 12 m that is thrown at random, down at up to 60 m/s.
void ground_add_thrown(mover *m, rng *r, uint32_t kind);

// Adds bodies of all kinds to an empty mover, which fall a little; and fails unless all of them
// rest on a level ground at height 0.
void ground_add_falling(mover *m);
void ground_assert_rest(const mover *m);

// Lets bodies of all kinds glide over a level ground at height 0, 58 m along a direction; fails if
// one loses speed or hops.
void ground_glide(mover *m, double speed, double direction);

// ---------------------------------------------------------------- what becomes of them

// The least separation of a contact's points.
double ground_least_of(const duet_contact *c);

// The least separation of each body from the ground, from what a step says; INFINITY: no contact.
void ground_least_separations(mover *m, double *least);

// Fails unless sixty bodies that are thrown on a ground come to the same bits by any share and
// skin.
void ground_assert_same_bits(const duet_heights *heights, const duet_mesh *mesh);

// Fails unless no motion like the mover's is made on this ground, with one line that has `says`.
void ground_assert_refused(const mover *m, const duet_heights *heights, const duet_mesh *mesh,
                           const char *says);

// Throws thirty bodies on a mover's ground, which move for `steps`.
mover *ground_throw(mover *m, uint32_t steps);

// Saves a motion, and fails unless it, and one on another ground, go on bit for bit once loaded.
void ground_assert_saved(mover *m, mover *other);

// Records 40 steps and fails unless they are replayed; replays them on another motion, which
// compares the hash in the last.
void ground_assert_recorded(mover *m);
bool ground_replay(mover *m, duet_error *err);

#endif
