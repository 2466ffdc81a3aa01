// SPDX-License-Identifier: MIT
// How one pair counts in the pair hash (duet_result_get_hash).
#ifndef RUNTIME_PAIR_HASH_H
#define RUNTIME_PAIR_HASH_H

#include <stdint.h>

// key: a << 32 | b. The hash of 0 is 0.
static inline uint64_t pair_hash(uint64_t key)
{
    key *= 0x9E3779B97F4A7C15u;
    key ^= key >> 29;
    key *= 0xBF58476D1CE4E5B9u;
    key ^= key >> 32;
    return key;
}

#endif
