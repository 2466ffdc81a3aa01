// SPDX-License-Identifier: MIT
// How the mass of a solid body lies about its centre.
#ifndef RUNTIME_INERTIA_H
#define RUNTIME_INERTIA_H

#include <stdint.h>

// One over the inertia of a box, or with a radius above 0 a rounded box, about each of its own
// axes: 0 if nothing turns it. In 2D only the last is other than 0.
void inertia_inverse(const float half_extents[3], float radius, double mass, uint32_t dims,
                     double inverse[3]);

#endif
