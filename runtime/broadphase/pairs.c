// SPDX-License-Identifier: MIT
// Pairs as a set: their hash, whoever found them and in whatever order.
#include "runtime/duet.h"

static uint64_t mix(duet_pair pair)
{
    uint64_t key = (uint64_t)pair.a << 32 | pair.b;
    key *= 0x9E3779B97F4A7C15u;
    key ^= key >> 29;
    key *= 0xBF58476D1CE4E5B9u;
    key ^= key >> 32;
    return key;
}

uint64_t duet_pairs_hash(const duet_pair *pairs, uint64_t n)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; pairs && i < n; ++i)
        sum += mix(pairs[i]);
    return sum;
}

uint64_t duet_result_get_hash(const duet_result *result)
{
    if (!result)
        return 0;
    return duet_pairs_hash(result->spans[0].pairs, result->spans[0].n) +
           duet_pairs_hash(result->spans[1].pairs, result->spans[1].n);
}

duet_pair duet_result_get_pair(const duet_result *result, uint64_t i)
{
    if (!result || i >= result->spans[0].n + result->spans[1].n)
        return (duet_pair){0, 0};
    const duet_span *a = &result->spans[0];
    return i < a->n ? a->pairs[i] : result->spans[1].pairs[i - a->n];
}
