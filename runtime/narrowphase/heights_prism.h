// SPDX-License-Identifier: MIT
// What lies under a triangle of a ground, without an end below: three upright planes and the
// triangle's own bound it.
#ifndef RUNTIME_HEIGHTS_PRISM_H
#define RUNTIME_HEIGHTS_PRISM_H

#include "runtime/narrowphase/heights.h"

enum { PRISM_TOP = 3, PRISM_PLANES = 4 };

typedef struct heights_prism {
    double corner[3][3];       // counterclockwise, seen from above
    bool is_rim[PRISM_PLANES]; // of the ground; the top is none
} heights_prism;

heights_prism heights_prism_of(const duet_heights *h, uint32_t i, uint32_t j, bool upper);

// As heights_meet.
bool heights_prism_meet(const heights_prism *p, const heights_probe *probe, heights_entry *entry);

// The same of a probe with a radius, whose core is the box; touching within 2^-40 of the sizes.
// entry->t is the latest time that counts.
bool heights_prism_meet_round(const heights_prism *p, const heights_probe *probe,
                              heights_entry *entry);

// An axis that may separate a prism from a box: its direction is out of the prism, or in both
// directions if it is level and none of the prism's own.
enum { PRISM_AXES = 19 }; // planes, the box's axes, products of edges

// Axes 7 to 15 are products of a box's axis and an edge of the triangle.
static inline bool prism_axis_is_product(int k, int *axis, int *edge)
{
    *axis = (k - 7) / 3;
    *edge = (k - 7) % 3;
    return k >= 7 && k < 16;
}

// By rational numbers alone; sets the time and the axis that separates last, -1 for none.
bool heights_prism_meet_exactly(const heights_prism *p, const heights_probe *probe, double *t,
                                int *entered);

#endif
