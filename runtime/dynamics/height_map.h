// SPDX-License-Identifier: MIT
// Which bodies stand on which when a motion begins.
#ifndef RUNTIME_HEIGHT_MAP_H
#define RUNTIME_HEIGHT_MAP_H

#include "runtime/duet.h"

// A body by its bounds in the plane below it. Axes past n_flat are 0.
typedef struct block {
    double bottom, top;     // of the line through the centre
    double at[2], reach[2]; // centre and half extents of its bounds in the plane
    double radius, mass;    // mass 0 does not move
    double edge;            // width^2 / height: the edge, if it is a cube
    uint32_t id;
} block;

// Places of blocks; `lower` is the smaller one.
typedef struct support {
    uint32_t upper, lower;
} support;

typedef struct height_map {
    block *blocks; // [n] by ascending bottom
    uint32_t n;
    uint32_t n_flat;   // axes of the plane
    support *supports; // [n_supports] by upper, then by lower
    uint64_t n_supports;
} height_map;

// Lists what stands on what. Gravity's greatest component says which way is up; a body stands on
// another if they are a margin apart at most, along the lines through their centres. Returns false
// if memory is short. Close it in either case.
bool height_map_open(height_map *map, const duet_motion *m);

void height_map_close(height_map *map);

#endif
