// SPDX-License-Identifier: MIT
// What of a world's objects decides how long a step takes: the workload that
// profiles are kept for. It is the scene's, whatever grid a plan makes of it.
#ifndef RUNTIME_CENSUS_H
#define RUNTIME_CENSUS_H

#include "runtime/duet.h"

struct profile_workload;

// Of all objects. What is not a number is passed over: no comparison holds.
typedef struct census {
    uint64_t version; // of the objects that were counted; 0: none
    float lower[3];   // of the centres
    float upper[3];
    float widest;    // by what decides an extent: squares of half diagonals of boxes that
    float narrowest; // may be turned, else half or, of bounds, whole sides; above 0
    double crowding; // objects in a cell where the fullest hundredth of the cells begins
} census;

// Reads all objects of a world that has some.
void census_take(census *c, const duet_world *world);

// What the world's objects are. Takes about as long as reading them once, unless
// a census was taken when they were set.
struct profile_workload census_of(const duet_world *world);

#endif
