// SPDX-License-Identifier: MIT
// Products of vectors in double.
#ifndef RUNTIME_VECTOR_H
#define RUNTIME_VECTOR_H

static inline double dot(const double u[3], const double v[3])
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static inline void cross(double out[3], const double u[3], const double v[3])
{
    for (int k = 0; k < 3; ++k)
        out[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
}

#endif
