// SPDX-License-Identifier: MIT
// How the mass of a rounded box lies about its centre.
#ifndef RUNTIME_ROUNDED_INERTIA_H
#define RUNTIME_ROUNDED_INERTIA_H

#include <stdint.h>

// The mean of x^2, y^2 and z^2 over a solid rounded box of one density, along its own axes; of a
// disc or rounded rectangle in 2D, where z^2 is 0. An inertia is the mass times the sum of two.
// The radius is above 0.
void rounded_spread(const float half_extents[3], float radius, uint32_t dims, double spread[3]);

#endif
