// SPDX-License-Identifier: MIT
// Orders for qsort and bsearch, and the lesser and the greater of two numbers.
#ifndef BASE_COMPARE_H
#define BASE_COMPARE_H

#include <stdint.h>

static inline int compare_uint32(const void *left, const void *right)
{
    uint32_t p = *(const uint32_t *)left, q = *(const uint32_t *)right;
    return (p > q) - (p < q);
}

static inline int compare_uint64(const void *left, const void *right)
{
    uint64_t p = *(const uint64_t *)left, q = *(const uint64_t *)right;
    return (p > q) - (p < q);
}

// Rows that begin with two, by the first and then the second: pairs, hits of queries and of bodies.
static inline int compare_uint32_pair(const void *left, const void *right)
{
    const uint32_t *p = left, *q = right;
    return p[0] != q[0] ? compare_uint32(&p[0], &q[0]) : compare_uint32(&p[1], &q[1]);
}

static inline int compare_double(const void *left, const void *right)
{
    double p = *(const double *)left, q = *(const double *)right;
    return (p > q) - (p < q);
}

// fmin and fmax are calls, because they treat NaN. These two are none: neither number may be NaN.
static inline double lesser(double a, double b)
{
    return a < b ? a : b;
}

static inline double greater(double a, double b)
{
    return a > b ? a : b;
}

#endif
