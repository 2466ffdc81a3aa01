// SPDX-License-Identifier: MIT
// Sizes in levels, and which place finds a pair: the one that owns the finer object; if both are of
// one level, the lower place. So large objects travel to small ones, and an object as wide as the
// world is a ghost only where small ones lie.
#ifndef CLUSTER_OWNER_H
#define CLUSTER_OWNER_H

#include "cluster/extent.h"

#include <stdint.h>

enum { SIZE_LEVELS = 16 };

// The level of an extent among objects of which `widest` is the widest: an octave each, from
// the widest down, and the last for all that is finer.
static inline int level_of(double width, double widest)
{
    int own = 0, top = 0;
    if (!isfinite(width) || width >= widest)
        return SIZE_LEVELS - 1;
    frexp(width, &own);
    frexp(widest, &top);
    int below = isfinite(widest) && width > 0 ? top - own : SIZE_LEVELS;
    return below < SIZE_LEVELS ? SIZE_LEVELS - 1 - below : 0;
}

// Boxes around the objects of each level and of all finer ones.
typedef struct level_boxes {
    extent upto[SIZE_LEVELS];
} level_boxes;

static inline void level_boxes_clear(level_boxes *boxes)
{
    for (int k = 0; k < SIZE_LEVELS; ++k)
        boxes->upto[k] = extent_none;
}

// Adds an object to the box of its own level. Levels are relative to the widest object.
static inline void level_boxes_add(level_boxes *boxes, const extent *e, double widest)
{
    extent_join(&boxes->upto[level_of(extent_widest(e), widest)], e);
}

// A pair is found at the place that owns the object with the lesser key.
static inline uint32_t owner_key(int level, uint32_t place, uint32_t n_places)
{
    return (uint32_t)level * n_places + place;
}

// Returns up to which level objects at `other` may own pairs with an object of that level at
// `place`; below 0: none.
static inline int owners_upto(int level, uint32_t place, uint32_t other)
{
    return other > place ? level - 1 : level;
}

#endif
