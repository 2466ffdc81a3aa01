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

// Bytes of the heights.
size_t heights_bytes(const duet_heights *h);

void heights_place(const duet_heights *h, uint32_t i, uint32_t j, double at[3]);

// A valid box on a straight way, or a ray, as a ground is asked about it: at centre + t direction
// for t from 0 to t_max.
typedef struct heights_probe {
    double centre[3], half[3], radius;
    float rotation[4], direction[3], t_max; // t_max is 0 without a direction
    const duet_bounds *bounds;              // the box, exactly; NULL: centre and half are exact
    double axis[3][3], sums[3][3];          // and the sums of amounts that these are made of
    double reach[3];                        // at least, along the world's axes
    double inexact;                         // 0, or with bounds 1
    bool is_point;
} heights_probe;

heights_probe heights_probe_of_ray(const duet_ray *ray);
heights_probe heights_probe_of_sweep(const duet_sweep *sweep);
heights_probe heights_probe_of_bounds(const duet_bounds_sweep *sweep); // borrowed
heights_probe heights_probe_of_box(const duet_pose *box);
heights_probe heights_probe_of_still_bounds(const duet_bounds *bounds); // borrowed
heights_probe heights_probe_of_rounded_sweep(const duet_rounded_sweep *sweep);
heights_probe heights_probe_of_rounded_box(const duet_rounded_box *box);

// Where it first touches the ground.
typedef struct heights_entry {
    double t;         // 0 if, and only if, it touches the ground at the begin
    double normal[3]; // outward, of any length
} heights_entry;

// Whether it meets the ground, touching included: in double with an error bound, then in rational
// numbers; with a radius in double, within 2^-40 of the sizes. Sets entry if it does.
bool heights_meet(const duet_heights *h, const heights_probe *probe, heights_entry *entry);

// Sets the normal of an entry, of length 1.
void heights_set_normal(const heights_entry *entry, float normal[3]);

// Whether a point lies in it.
bool heights_contain(const duet_heights *h, const float at[3]);

// How far a point is from the ground, 0 in it.
double heights_distance(const duet_heights *h, const float at[3]);

#endif
