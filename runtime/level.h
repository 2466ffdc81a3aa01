// SPDX-License-Identifier: MIT
// Levels of accuracy: what a narrow phase may take for a collision, and what
// it may miss. Every level starts from the pairs whose bounds overlap.
//
// In float a level is computed operation for operation as on the devices, so
// that what a device finds at a level can be compared bit by bit.
#ifndef RUNTIME_LEVEL_H
#define RUNTIME_LEVEL_H

#include "runtime/duet.h"

typedef enum level {
    LEVEL_CERTIFIED, // the default: never wrong
    LEVEL_AABB,
    LEVEL_SPHERE,
    LEVEL_SAT6,
    LEVEL_SAT15,
    LEVEL_DOUBLE,
    LEVEL_COUNT
} level;

// What a level promises for boxes of which |t|_1 and all half extents add up to
// S, 2^-70 <= S <= 2^100. A gap is the greatest of the 15 axes (4 in 2D), where
// an axis across two edges has the length of the sine between them.
typedef struct level_info {
    const char *name;
    const char *about; // what is tested
    double missed;     // a colliding pair is missed only where its gap is above -missed * S
    double added;      // a separated one is reported only where it is at most added * S
} level_info;

const level_info *level_describe(level l);

// The level called that, or LEVEL_COUNT.
level level_named(const char *name);

// Whether the level takes the two for colliding. rotated false: both rotations
// are the identity, and all levels but aabb and sphere are exact.
bool level_collide(level l, const duet_pose *a, const duet_pose *b, uint32_t dims, bool rotated);

#endif
