// SPDX-License-Identifier: MIT
// The plain-C twin of the pipeline: slow, simple and never wrong. It shares
// nothing with the devices' side but the exact test of two boxes. Levels other
// than certified are what the devices' arithmetic makes them, and so is their set.
#ifndef RUNTIME_REFERENCE_H
#define RUNTIME_REFERENCE_H

#include "runtime/narrowphase/level.h"

// Objects as the caller holds them; one of the four arrays, as shape says.
typedef struct reference_objects {
    uint32_t dims;
    duet_shape shape;
    uint32_t n;
    const duet_pose *poses; // with an origin placed ones: duet_large_pose [n]
    const duet_bounds *bounds;
    const duet_rounded_box *rounded_boxes;
    const duet_sphere *spheres;
    duet_level level; // but of bounds; by default certified
    bool rotated;     // false promises identity rotations, at levels other than certified
    float origin;     // the edge of origin cells, or 0
} reference_objects;

typedef enum reference_way {
    REFERENCE_EACH_WITH_EACH, // n^2 / 2 tests
    REFERENCE_COLUMNS         // objects by size, then by column of the world
} reference_way;

// The result. The pairs are ascending by (a, b), each with a < b.
typedef struct reference_found {
    duet_pair *pairs; // given back by duet_free
    uint64_t n;
    uint64_t candidates; // pairs whose bounds overlap: in double, or as the level has them
} reference_found;

// False with NO_MEMORY. Objects must be sound boxes, as a scene's are.
bool reference_find(const reference_objects *objects, reference_way way, reference_found *found,
                    duet_error *err);

#endif
