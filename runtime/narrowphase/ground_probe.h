// SPDX-License-Identifier: MIT
// A probe, which asks about a ground, and the entry that it is told.
#ifndef RUNTIME_GROUND_PROBE_H
#define RUNTIME_GROUND_PROBE_H

#include "runtime/duet.h"

// A valid box on a straight way, or a ray, as a ground is asked about it: at centre + t direction
// for t from 0 to t_max.
typedef struct ground_probe {
    double centre[3], half[3], radius;
    float rotation[4], direction[3], t_max; // t_max is 0 without a direction
    const duet_bounds *bounds;              // the box, exactly; NULL: centre and half are exact
    double axis[3][3], sums[3][3];          // and the sums of amounts that these are made of
    double reach[3];                        // at least, along the world's axes
    double inexact;                         // 0, or with bounds 1
    bool is_point;
} ground_probe;

ground_probe ground_probe_of_ray(const duet_ray *ray);
ground_probe ground_probe_of_sweep(const duet_sweep *sweep);
ground_probe ground_probe_of_bounds(const duet_bounds_sweep *sweep); // borrowed
ground_probe ground_probe_of_box(const duet_pose *box);
ground_probe ground_probe_of_still_bounds(const duet_bounds *bounds); // borrowed
ground_probe ground_probe_of_rounded_sweep(const duet_rounded_sweep *sweep);
ground_probe ground_probe_of_rounded_box(const duet_rounded_box *box);

// The first time and place at which a probe touches the ground.
typedef struct ground_entry {
    double t;         // 0 if, and only if, it touches the ground at the begin
    double normal[3]; // outward, of any length
} ground_entry;

// Sets the normal of an entry, of length 1.
void ground_set_normal(const ground_entry *entry, float normal[3]);

#endif
