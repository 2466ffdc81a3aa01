// SPDX-License-Identifier: MIT
// A workload that was measured beside one that was not: how far the two are apart, and what the
// measured one says of the other. Nothing here reads the store.
//
// One assumption carries all of it: with more work the time of a step grows at least as the square
// root of the work, and no faster than the work. So a plan that was faster than another by a factor
// of f is the faster one wherever the work differs by less than f squared.
#ifndef PROFILES_NEIGHBOUR_H
#define PROFILES_NEIGHBOUR_H

#include "profiles/lookup.h"

// Quantities that the time of a step follows from, within a family of workloads.
typedef enum neighbour_quantity {
    NEIGHBOUR_OBJECTS,
    NEIGHBOUR_OCCUPANCY, // objects a cell, in the mean
    NEIGHBOUR_CROWDING,  // and in the fullest hundredth of the cells
    NEIGHBOUR_SIZES,     // the largest extent by the smallest
    NEIGHBOUR_LAYERS,    // layers of cells along the axis that slabs are cut from
    NEIGHBOUR_QUANTITIES
} neighbour_quantity;

const char *neighbour_quantity_name(neighbour_quantity quantity); // "objects", ...

typedef struct neighbour {
    double quantities[NEIGHBOUR_QUANTITIES]; // 0 objects: there is none
    profile_found found;
} neighbour;

void neighbour_describe(const profile_workload *w, double quantities[NEIGHBOUR_QUANTITIES]);

static inline bool neighbour_is_there(const neighbour *near)
{
    return near->quantities[NEIGHBOUR_OBJECTS] > 0;
}

// The largest ratio of any quantity, at least 1; in `worst`, unless NULL, the quantity.
double neighbour_ratio(const double a[NEIGHBOUR_QUANTITIES], const double b[NEIGHBOUR_QUANTITIES],
                       neighbour_quantity *worst);

// Whether both can be one scene with different numbers of objects: as unevenly filled, with as
// unlike sizes, and of a density that changed no more than the number.
bool neighbour_is_alike(const double a[NEIGHBOUR_QUANTITIES], const double b[NEIGHBOUR_QUANTITIES]);

// Whether they are almost the same: within a tenth of the objects, and a quarter of the rest.
bool neighbour_is_next(const double a[NEIGHBOUR_QUANTITIES], const double b[NEIGHBOUR_QUANTITIES]);

// How far apart (neighbour_ratio) the neighbour's choice, between sharing and device B alone, is
// still the faster one. 1: nowhere else. A alone may be slower than B elsewhere, which nobody
// measured.
double neighbour_safe_ratio(const profile_found *found);

// Predicts a workload from a neighbour: its plan, without any figure.
void neighbour_copy_plan(const profile_found *near, profile_found *found);

// Predicts a workload next to the neighbour: its plan, and figures. Times are in proportion to
// the objects, the interval of the gain widened by how far they are apart.
void neighbour_scale(const neighbour *near, const double at[NEIGHBOUR_QUANTITIES],
                     profile_found *found);

// Predicts a workload between two neighbours that are alike. Times lie on the line through both,
// the gain between both gains. If one shares the work and the other does not, the predicted times
// decide. False if one says A alone and the other B alone: no time of either device is known
// between.
bool neighbour_between(const neighbour *below, const neighbour *above,
                       const double at[NEIGHBOUR_QUANTITIES], profile_found *found);

#endif
