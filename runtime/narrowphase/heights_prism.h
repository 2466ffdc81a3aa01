// SPDX-License-Identifier: MIT
// What lies under a triangle of a ground: three upright planes and the triangle's own bound it.
#ifndef RUNTIME_HEIGHTS_PRISM_H
#define RUNTIME_HEIGHTS_PRISM_H

#include "runtime/narrowphase/heights.h"

enum { PRISM_TOP = 3, PRISM_PLANES = 4 };

typedef struct heights_prism {
    double corner[3][3];       // counterclockwise, seen from above
    bool is_rim[PRISM_PLANES]; // of the ground; the top is none
} heights_prism;

heights_prism heights_prism_of(const duet_heights *h, uint32_t i, uint32_t j, bool upper);

// As heights_meet_ray.
bool heights_prism_meet(const heights_prism *p, const duet_ray *ray, heights_entry *entry);

#endif
