// SPDX-License-Identifier: MIT
// Levels of accuracy.
#ifndef DUET_LEVEL_H
#define DUET_LEVEL_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// Levels of accuracy: what may be taken for a collision, and what may be missed.
// Every level starts from the pairs whose bounds, rounded outward, overlap, and
// finds the same pairs on every device, at every share and in every grid.
typedef enum duet_level {
    DUET_LEVEL_CERTIFIED, // the default: never wrong
    DUET_LEVEL_AABB,      // the bounds alone: misses none
    DUET_LEVEL_SPHERE,    // bounding spheres: misses none
    DUET_LEVEL_SAT6,      // the faces' axes: misses none
    DUET_LEVEL_SAT15,     // 15 axes in float as textbooks have it: wrong both ways, within bounds
    DUET_LEVEL_DOUBLE     // 15 axes in double (the devices must have it): the same, far closer
} duet_level;

#define DUET_LEVELS 6

// What a level promises for boxes of which |t|_1 and all half extents add up to
// S, 2^-70 <= S <= 2^100. A separation is the greatest of the 15 axes (4 in 2D), where
// an axis across two edges has the length of the sine between them. Where
// nothing is rotated all levels but aabb and sphere are exact.
typedef struct duet_level_info {
    const char *name;
    const char *about; // what is tested
    double missed;     // a colliding pair is missed only where its separation is above -missed * S
    double added;      // a separated one is reported only where it is at most added * S
} duet_level_info;

DUET_API const duet_level_info *duet_level_get_info(duet_level level); // NULL outside

// False where no level is called that.
DUET_API bool duet_level_from_name(const char *name, duet_level *level);

// Whether a level promises all that another does: certified does so for all,
// aabb, sphere and sat6 for each other (none is missed), double for sat15. False for
// what is no level.
DUET_API bool duet_level_covers(duet_level level, duet_level other);

// How much may be wrong, by the number of pairs that collide: 0.02 is two in a
// hundred. Levels are measured for it on a workload; certified is within any.
typedef struct duet_accuracy {
    double missed;     // of those pairs, not found; 0 to 1
    double false_rate; // found besides those pairs; >= 0
} duet_accuracy;

DUET_C_END

#endif
