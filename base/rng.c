// SPDX-License-Identifier: MIT
#include "base/rng.h"

#include <math.h>

rng rng_seed(uint64_t seed)
{
    rng r = {seed + 1442695040888963407u};
    rng_next(&r);
    return r;
}

// A number of which each bit depends on each of x (the finaliser of SplitMix64).
static uint64_t mix(uint64_t x)
{
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

// Seeds that are neighbours would begin on the one sequence with numbers that are related.
rng rng_stream(uint64_t seed, uint64_t number)
{
    return rng_seed(mix(mix(seed) + number * 0x9e3779b97f4a7c15u));
}

uint32_t rng_next(rng *r)
{
    uint64_t old = r->state;
    r->state = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t mixed = (uint32_t)(((old >> 18) ^ old) >> 27);
    uint32_t turn = (uint32_t)(old >> 59);
    return (mixed >> turn) | (mixed << ((32 - turn) & 31));
}

uint32_t rng_below(rng *r, uint32_t bound)
{
    uint32_t reject_below = (0u - bound) % bound;
    for (;;) {
        uint32_t drawn = rng_next(r);
        if (drawn >= reject_below)
            return drawn % bound;
    }
}

double rng_unit(rng *r)
{
    uint64_t high = rng_next(r) >> 5;
    uint64_t low = rng_next(r) >> 6;
    return (double)(high << 26 | low) * 0x1p-53;
}

double rng_between(rng *r, double from, double to)
{
    return from + (to - from) * rng_unit(r);
}

double rng_normal(rng *r)
{
    double radius = sqrt(-2.0 * log(1.0 - rng_unit(r)));
    return radius * cos(6.283185307179586476925 * rng_unit(r));
}
