// SPDX-License-Identifier: MIT
// Levels of accuracy.
#ifndef DUET_LEVEL_H
#define DUET_LEVEL_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// Levels of accuracy: which pairs a level may add, and which it may miss.
// Every level starts from the pairs whose bounds, rounded outward, overlap, and
// finds the same pairs on every device, at every share and in every grid.
typedef enum duet_level {
    DUET_LEVEL_CERTIFIED, // the default: never wrong
    DUET_LEVEL_AABB,      // the bounds alone: misses none
    DUET_LEVEL_SPHERE,    // bounding spheres: misses none
    DUET_LEVEL_SAT6,      // the faces' axes: misses none
    DUET_LEVEL_SAT15,     // 15 axes in float as textbooks have it: wrong both ways, within bounds
    DUET_LEVEL_DOUBLE     // 15 axes in double, if the devices have it: likewise, far closer
} duet_level;

#define DUET_LEVELS 6

// The promise of a level for two boxes with 2^-70 <= S <= 2^100, S being the sum of |t|_1 and all
// half extents. A separation is the greatest of the 15 axes (4 in 2D); an axis across two edges
// has the length of the sine between them. If nothing is rotated, all levels but aabb and
// sphere are exact.
typedef struct duet_level_info {
    const char *name;
    const char *about; // names what is tested
    double missed;     // misses a colliding pair only if its separation is above -missed * S
    double added;      // reports a separated pair only if its separation is at most added * S
} duet_level_info;

DUET_API const duet_level_info *duet_level_get_info(duet_level level); // NULL outside

// Returns false if no level has this name.
DUET_API bool duet_level_from_name(const char *name, duet_level *level);

// Says whether a level promises all that another does: certified covers all,
// aabb, sphere and sat6 each other (none misses a pair), double covers sat15. False for
// values outside the enum.
DUET_API bool duet_level_covers(duet_level level, duet_level other);

// How much may be wrong, as a share of the pairs that collide: 0.02 is two in a
// hundred. Levels are measured for it on a workload; certified is within any accuracy.
typedef struct duet_accuracy {
    double missed;     // colliding pairs that are not found; 0 to 1
    double false_rate; // pairs found that do not collide; >= 0
} duet_accuracy;

DUET_C_END

#endif
