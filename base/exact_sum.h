// SPDX-License-Identifier: MIT
// A sum of doubles without any rounding: the same bits in any order. A fixed-point number as wide
// as all doubles (Kulisch's accumulator).
#ifndef BASE_EXACT_SUM_H
#define BASE_EXACT_SUM_H

#include <stdint.h>

// Bits from 2^-1074 to 2^1024, and 64 for carries.
enum { EXACT_SUM_LIMBS = 68 };

// Zeroed is 0. The sum is that of limbs[k] * 2^(32 k - 1074), with `wild`.
// Invariant: a limb is below 2^33 * (carried + 2) in size.
typedef struct exact_sum {
    int64_t limbs[EXACT_SUM_LIMBS];
    uint64_t carried; // additions since the limbs' last carries
    double wild;      // sum of what is infinite or NaN
} exact_sum;

void exact_sum_add(exact_sum *s, double x);

// Returns the double nearest to the sum, of two the even one; beyond them an infinity.
double exact_sum_round(const exact_sum *s);

#endif
