// SPDX-License-Identifier: MIT
#include "base/exact_sum.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { LIMB = 32, MANTISSA = 53, LEAST_EXPONENT = -1074, BETWEEN_CARRIES = 1 << 28 };

static const int64_t limb_end = (int64_t)1 << LIMB;

// ---------------------------------------------------------------- limbs

// Each limb but the last into [0, 2^32); the last one has the sign.
static void carry(int64_t limbs[EXACT_SUM_LIMBS])
{
    for (int k = 0; k + 1 < EXACT_SUM_LIMBS; ++k) {
        int64_t low = limbs[k] & (limb_end - 1); // in two's complement
        limbs[k + 1] += (limbs[k] - low) / limb_end;
        limbs[k] = low;
    }
}

static void note_addition(exact_sum *s)
{
    if (++s->carried < BETWEEN_CARRIES)
        return;
    carry(s->limbs);
    s->carried = 0;
}

void exact_sum_add(exact_sum *s, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    uint32_t exponent = bits >> (MANTISSA - 1) & 0x7ff;
    uint64_t mantissa = bits & ((UINT64_C(1) << (MANTISSA - 1)) - 1);
    if (exponent == 0x7ff) {
        s->wild += x;
        return;
    }
    if (exponent > 0)
        mantissa |= UINT64_C(1) << (MANTISSA - 1);
    uint32_t at = exponent > 0 ? exponent - 1 : 0;
    uint64_t low = (mantissa & (limb_end - 1)) << at % LIMB;
    uint64_t high = (mantissa >> LIMB) << at % LIMB;
    int64_t sign = x < 0 ? -1 : 1, *limb = &s->limbs[at / LIMB];
    limb[0] += sign * (int64_t)(low & (limb_end - 1));
    limb[1] += sign * (int64_t)((low >> LIMB) + (high & (limb_end - 1)));
    limb[2] += sign * (int64_t)(high >> LIMB);
    note_addition(s);
}

// ---------------------------------------------------------------- rounding

static bool is_set(const int64_t *limbs, int bit)
{
    return limbs[bit / LIMB] >> bit % LIMB & 1;
}

// The highest bit that is set; -1: none is.
static int highest_bit(const int64_t *limbs)
{
    int bit = EXACT_SUM_LIMBS * LIMB - 1;
    while (bit >= 0 && !is_set(limbs, bit))
        --bit;
    return bit;
}

static bool any_below(const int64_t *limbs, int bit)
{
    for (int k = 0; k < bit; ++k)
        if (is_set(limbs, k))
            return true;
    return false;
}

// Rounds limbs that are carried and not below 0.
static double round_limbs(const int64_t *limbs)
{
    int top = highest_bit(limbs), last = top >= MANTISSA ? top - MANTISSA + 1 : 0;
    uint64_t mantissa = 0;
    for (int bit = top; bit >= last; --bit)
        mantissa = mantissa << 1 | is_set(limbs, bit);
    bool half = last > 0 && is_set(limbs, last - 1);
    if (half && ((mantissa & 1) || any_below(limbs, last - 1)))
        ++mantissa;
    return ldexp((double)mantissa, last + LEAST_EXPONENT);
}

double exact_sum_round(const exact_sum *s)
{
    int64_t limbs[EXACT_SUM_LIMBS];
    if (s->wild != 0.0)
        return s->wild;
    memcpy(limbs, s->limbs, sizeof limbs);
    carry(limbs);
    bool negative = limbs[EXACT_SUM_LIMBS - 1] < 0;
    for (int k = 0; negative && k < EXACT_SUM_LIMBS; ++k)
        limbs[k] = -limbs[k];
    if (negative)
        carry(limbs);
    double rounded = round_limbs(limbs);
    return negative ? -rounded : rounded;
}
