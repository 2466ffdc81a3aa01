// SPDX-License-Identifier: MIT
// Vectors on the host.
#ifndef RUNTIME_VECTOR_H
#define RUNTIME_VECTOR_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

static inline void vector_cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double vector_dot(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k)
        sum += a[k] * b[k];
    return sum;
}

static inline bool vector_is_finite(const float *values, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(values[i]))
            return false;
    return true;
}

#endif
