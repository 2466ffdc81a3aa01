// SPDX-License-Identifier: MIT
// Motions for tests: a def, objects that are added, and what became of them.
#ifndef TESTS_MOVER_H
#define TESTS_MOVER_H

#include "runtime/duet.h"

enum { MOVER_MOST = 4096 };

typedef struct mover {
    duet_motion_def def;
    duet_pose poses[MOVER_MOST];
    duet_body bodies[MOVER_MOST];
    uint32_t n;
    duet_motion *motion;
    duet_motion_result last;
    duet_state states[MOVER_MOST]; // the bodies as mover_run left them
} mover;

// An empty mover on the default pair, in 2D or 3D, which lasts until the test ends or mover_free.
mover *mover_new(uint32_t dims);
void mover_free(mover *m);

// Adds a box at rest and returns its place; its body may be changed until the
// first step. A fixed one has no mass.
uint32_t mover_add(mover *m, double x, double y, double z, double hx, double hy, double hz);
uint32_t mover_add_fixed(mover *m, double x, double y, double z, double hx, double hy, double hz);
uint32_t mover_add_cube(mover *m, double x, double y, double z, double edge);
void mover_wall_in(mover *m, double from, double to); // walls at these places of each axis
void mover_turn(mover *m, uint32_t id, double x, double y, double z, double angle);

// A floor whose top is at height 0, and gravity; a unit cube with friction; n boxes
// of many shapes that fall between walls.
uint32_t mover_add_floor(mover *m, double half);
uint32_t mover_add_rough_cube(mover *m, double x, double y, double z);
void mover_add_pile(mover *m, uint32_t n);

// On a floor of their own: unit cubes in rows, each half on two of the row below; a house
// of cards, 20 x 400 x 400 mm with friction 0.7, pairs that lean on each other under cards
// that lie.
void mover_add_pyramid(mover *m, uint32_t rows);
void mover_add_card_house(mover *m, uint32_t levels);

// Makes the motion, if there is none, advances it and reads the states.
void mover_run(mover *m, uint32_t steps);
void mover_restart(mover *m); // forgets the motion
void mover_run_alike(mover *m, mover *other,
                     uint32_t steps); // fails unless both have the same bits
duet_energy mover_energy(mover *m);
uint64_t mover_hash(mover *m);
duet_contact *mover_contacts(mover *m, uint64_t *n);    // these last until the test ends
double mover_total(mover *m);                           // energy of all kinds
duet_pose mover_pose(const mover *m, uint32_t id);      // in float, as mover_run read it
bool mover_has_stage(const mover *m, const char *name); // in the last step
double mover_speed(const mover *m, uint32_t id);
double mover_greatest_speed(const mover *m);
duet_tree *mover_tree(const mover *m);    // over the bodies as they are; lasts until the test ends
void mover_assert_finite(const mover *m); // checks what mover_run read

// CMocka compares floats.
#define assert_close(a, b, bound)                                                           \
    do {                                                                                    \
        double is_ = (a), right_ = (b);                                                     \
        if (!(is_ - right_ <= (bound) && right_ - is_ <= (bound)))                          \
            fail_msg("%s is %.17g, not %.17g within %g", #a, is_, right_, (double)(bound)); \
    } while (0)

#endif
