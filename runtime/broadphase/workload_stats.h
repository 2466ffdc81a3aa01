// SPDX-License-Identifier: MIT
// The facts of a world's objects that decide how long a step takes: the workload that
// profiles are kept for. It is the scene's, whatever grid a plan makes of it.
#ifndef RUNTIME_WORKLOAD_STATS_H
#define RUNTIME_WORKLOAD_STATS_H

#include "runtime/duet.h"

// Statistics of all objects. NaN is passed over: no comparison holds.
typedef struct workload_stats {
    uint32_t n;     // counted objects; 0: none
    float lower[3]; // the centres' least
    float upper[3];
    float widest;    // by what decides an extent: squares of half diagonals of boxes that
    float narrowest; // may be turned, else half or, of bounds, whole sides; above 0
    double crowding; // objects in a cell where the fullest hundredth of the cells begins
} workload_stats;

// Reads all objects of a world that has some.
void workload_stats_take(workload_stats *c, const duet_world *world);

// The numbers that tell profiles of a workload apart.
typedef struct workload_summary {
    uint32_t cells[3];
    double cell;           // edge
    double mean_occupancy; // objects a cell
    double crowding;       // the same as in workload_stats
    double size_ratio;     // the widest object by the narrowest
    double strays;         // an ordered world's: the part of its objects that would lie in the
                           // other half, were rows of cells cut in two; 0.5 at random. Else 0
} workload_summary;

// Takes about as long as reading all objects once, unless statistics were taken
// when they were set.
workload_summary workload_summarise(const duet_world *world);

#endif
