// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/exact.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>

void exact_open(void *numbers, size_t bytes)
{
    for (mpz_t *at = numbers, *end = at + bytes / sizeof *at; at < end; ++at)
        mpz_init(*at);
}

void exact_close(void *numbers, size_t bytes)
{
    for (mpz_t *at = numbers, *end = at + bytes / sizeof *at; at < end; ++at)
        mpz_clear(*at);
}

int exact_least_power(const float *values, int n, int so_far)
{
    for (int i = 0; i < n; ++i) {
        int power;
        frexp(values[i], &power);
        if (values[i] != 0 && power - 24 < so_far)
            so_far = power - 24;
    }
    return so_far;
}

int exact_least_power_of_doubles(const double *values, int n, int so_far)
{
    for (int i = 0; i < n; ++i) {
        int power;
        frexp(values[i], &power);
        if (values[i] != 0 && power - 53 < so_far)
            so_far = power - 53;
    }
    return so_far;
}

void exact_integer(mpz_t out, double value, int power)
{
    mpz_set_d(out, ldexp(value, -power));
}

// out = 2 (x y + sign z w)
static void set_twice(mpz_t out, const mpz_t x, const mpz_t y, int sign, const mpz_t z,
                      const mpz_t w)
{
    mpz_mul(out, x, y);
    (sign > 0 ? mpz_addmul : mpz_submul)(out, z, w);
    mpz_mul_2exp(out, out, 1);
}

// out = w w + plus plus - minus minus - less less
static void set_diagonal(mpz_t out, const mpz_t w, const mpz_t plus, const mpz_t minus,
                         const mpz_t less)
{
    mpz_mul(out, w, w);
    mpz_addmul(out, plus, plus);
    mpz_submul(out, minus, minus);
    mpz_submul(out, less, less);
}

void exact_axes(mpz_t axis[3][3], mpz_t norm, mpz_t q[4], const float rotation[4])
{
    int power = exact_least_power(rotation, 4, INT_MAX);
    mpz_set_ui(norm, 0);
    for (int i = 0; i < 4; ++i) {
        exact_integer(q[i], rotation[i], power);
        mpz_addmul(norm, q[i], q[i]);
    }
    set_diagonal(axis[0][0], q[3], q[0], q[1], q[2]);
    set_twice(axis[0][1], q[0], q[1], 1, q[3], q[2]);
    set_twice(axis[0][2], q[0], q[2], -1, q[3], q[1]);
    set_twice(axis[1][0], q[0], q[1], -1, q[3], q[2]);
    set_diagonal(axis[1][1], q[3], q[1], q[0], q[2]);
    set_twice(axis[1][2], q[1], q[2], 1, q[3], q[0]);
    set_twice(axis[2][0], q[0], q[2], 1, q[3], q[1]);
    set_twice(axis[2][1], q[1], q[2], -1, q[3], q[0]);
    set_diagonal(axis[2][2], q[3], q[2], q[0], q[1]);
}

void exact_dot(mpz_t out, mpz_t u[3], mpz_t v[3])
{
    mpz_mul(out, u[0], v[0]);
    mpz_addmul(out, u[1], v[1]);
    mpz_addmul(out, u[2], v[2]);
}

void exact_cross(mpz_t *out, mpz_t *u, mpz_t *v)
{
    for (int k = 0; k < 3; ++k) {
        mpz_mul(out[k], u[(k + 1) % 3], v[(k + 2) % 3]);
        mpz_submul(out[k], u[(k + 2) % 3], v[(k + 1) % 3]);
    }
}

int exact_step(mpz_t out[3], const float direction[3], float t_max, int power)
{
    bool ends = isfinite(t_max);
    int t_power = exact_least_power(&t_max, ends, 0);
    int v_power = exact_least_power(direction, 3, 0);
    if (ends && t_power + v_power < power)
        power = t_power + v_power;
    mpz_t last;
    mpz_init(last);
    exact_integer(last, ends ? t_max : 1, t_power);
    for (int k = 0; k < 3; ++k) {
        exact_integer(out[k], direction[k], v_power);
        if (!ends)
            continue;
        mpz_mul(out[k], out[k], last);
        mpz_mul_2exp(out[k], out[k], (mp_bitcnt_t)(t_power + v_power - power));
    }
    mpz_clear(last);
    return power;
}
