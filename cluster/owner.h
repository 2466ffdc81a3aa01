// SPDX-License-Identifier: MIT
// Sizes in levels, and which rank finds a pair: the home of the finer object; where both are
// of one level, the home that is the lower rank. So large objects travel to small ones, and
// what is as wide as the world is a ghost only where it lies.
#ifndef CLUSTER_OWNER_H
#define CLUSTER_OWNER_H

#include <math.h>
#include <stdint.h>

enum { LEVELS = 16 };

// The level of an extent among objects of which `widest` is the widest: an octave each, from
// the widest down, and the last for all that is finer.
static inline int level_of(double width, double widest)
{
    int own = 0, top = 0;
    if (!isfinite(width) || width >= widest)
        return LEVELS - 1;
    frexp(width, &own);
    frexp(widest, &top);
    int below = isfinite(widest) && width > 0 ? top - own : LEVELS;
    return below < LEVELS ? LEVELS - 1 - below : 0;
}

// A pair is found where the object with the lesser key is at home: on a rank, or in one of the
// parts that a rank's homes are in.
static inline uint32_t owner_key(int level, uint32_t home, uint32_t n_homes)
{
    return (uint32_t)level * n_homes + home;
}

// Of a place's objects these may be owners of pairs with an object of that level that is at home
// elsewhere: those up to a level, or none below 0.
static inline int owners_upto(int level, uint32_t home, uint32_t place)
{
    return place > home ? level - 1 : level;
}

#endif
