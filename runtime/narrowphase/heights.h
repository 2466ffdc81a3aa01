// SPDX-License-Identifier: MIT
// A ground of heights as queries see it: the closed set of all points under its triangles, without
// an end below, with upright walls at its rim.
//
// Its places are doubles, origin + i spacing rounded once. All answers are about these, and made on
// the host: bits are the same on every machine.
#ifndef RUNTIME_HEIGHTS_H
#define RUNTIME_HEIGHTS_H

#include "runtime/duet.h"

// BAD_ARGUMENT for a ground that nothing can have.
bool heights_check(const duet_heights *h, duet_error *err);

// Also for one whose places doubles do not tell apart well.
bool heights_check_places(const duet_heights *h, duet_error *err);

void heights_place(const duet_heights *h, uint32_t i, uint32_t j, double at[3]);

// Where a ray enters the ground.
typedef struct heights_entry {
    double t;         // 0: it begins in the ground
    double normal[3]; // outward, of any length
} heights_entry;

// Whether the ray meets the ground: in double with an error bound, then in rational numbers. The
// ray is valid. Sets entry if it does.
bool heights_meet_ray(const duet_heights *h, const duet_ray *ray, heights_entry *entry);

// The same of a point.
bool heights_contain(const duet_heights *h, const float at[3]);

// How far a point is from the ground, 0 in it.
double heights_distance(const duet_heights *h, const float at[3]);

#endif
