// SPDX-License-Identifier: MIT
// Boxes in whole numbers: a float is an integer times a power of two. The
// answers that are made so are narrow_exact (narrow.h) and rounded_exact (rounded.h).
#ifndef RUNTIME_EXACT_H
#define RUNTIME_EXACT_H

#include "runtime/duet.h"

#include <gmp.h>
#include <stddef.h>

// Makes a struct of nothing but mpz_t ready, and frees it; bytes is its size.
void exact_open(void *numbers, size_t bytes);
void exact_close(void *numbers, size_t bytes);

// The power of two that makes integers of all n values, if below so_far.
int exact_least_power(const float *values, int n, int so_far);
int exact_least_power_of_boxes(const duet_pose *a, const duet_pose *b, const double shift[3],
                               int so_far);

// out = value / 2^power, which is an integer
void exact_integer(mpz_t out, double value, int power);

// The same of to - from + shift; term is overwritten.
void exact_way(mpz_t out[3], const float from[3], const float to[3], const double shift[3],
               int power, mpz_t term);

// axis[i]: the direction of edge i, of length norm = |q|^2. The quaternion's own power of
// two is left out, for M(q)/|q|^2 does not feel it.
void exact_axes(mpz_t axis[3][3], mpz_t norm, mpz_t q[4], const float rotation[4]);

void exact_dot(mpz_t out, mpz_t u[3], mpz_t v[3]);
void exact_cross(mpz_t *out, mpz_t *u, mpz_t *v); // the cross product; three numbers each

// The way from t = 0 to t_max by direction, in units of 2^p; without an end the direction, in any
// unit. Returns p, which is power or less.
int exact_step(mpz_t out[3], const float direction[3], float t_max, int power);

#endif
