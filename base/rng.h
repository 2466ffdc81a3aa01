// SPDX-License-Identifier: MIT
// Random numbers that are the same on every machine: PCG32 (O'Neill 2014,
// pcg_oneseq_64_xsh_rr_32), one 64-bit state, no hidden globals.
#ifndef BASE_RNG_H
#define BASE_RNG_H

#include <stdint.h>

typedef struct rng {
    uint64_t state;
} rng;

rng rng_seed(uint64_t seed);
rng rng_stream(uint64_t seed, uint64_t number);     // one of many sources of a seed
uint32_t rng_next(rng *r);                          // 0 .. 2^32-1
uint32_t rng_below(rng *r, uint32_t bound);         // 0 .. bound-1, without bias; bound > 0
double rng_unit(rng *r);                            // [0, 1), 53 bits
double rng_between(rng *r, double from, double to); // [from, to)
double rng_normal(rng *r);                          // mean 0, deviation 1

#endif
