// SPDX-License-Identifier: MIT
// Whether a ray meets a box, decided on the host and never wrongly.
#ifndef RUNTIME_RAY_H
#define RUNTIME_RAY_H

#include "runtime/duet.h"

// Whether some origin + t direction with 0 <= t <= t_max lies in the closed box: in double
// with an error bound, then in exact integers. Both are valid.
bool ray_meets(const duet_ray *ray, const duet_pose *box, uint32_t dims);

// The same where the ray lies `shift` further than it says, as between origin cells.
bool ray_meets_apart(const duet_ray *ray, const duet_pose *box, const double shift[3],
                     uint32_t dims);

// By integers alone.
bool ray_meets_exactly(const duet_ray *ray, const duet_pose *box, uint32_t dims);

// Whether it comes as near to the core as the radius, by integers alone. *t is then raised to
// where it first is that near, as far as double tells.
bool ray_meets_rounded(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims, float *t);

// The normal of a box that a ray meets where it enters, as duet_ray_normal has it; by double, and
// exact in whether it is 0.
void ray_normal(const duet_ray *ray, const duet_pose *box, const double shift[3], uint32_t dims,
                float normal[3]);
void ray_normal_of_bounds(const duet_ray *ray, const duet_bounds *box, uint32_t dims,
                          float normal[3]);
void ray_normal_of_rounded(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims,
                           float normal[3]);

#endif
