// SPDX-License-Identifier: MIT
// A rounded box is its core, a slab on each face, a quarter of a cylinder along each edge and an
// eighth of a ball at each corner. The volume and the mean of x^2 of each are known, so that the
// sums are exact (docs/notes/effects.md, "Rounded boxes").
#include "runtime/dynamics/inertia.h"

#include <stdbool.h>

static const double pi = 3.14159265358979323846;

// The mean square of h + u, of a u with this mean and mean square.
static double beyond(double h, double mean, double square)
{
    return h * h + 2.0 * h * mean + square;
}

typedef struct tally {
    double volume, squares;
} tally;

static void add(tally *t, double volume, double square)
{
    t->volume += volume;
    t->squares += volume * square;
}

static double mean_square_2d(double h, double across, double r)
{
    tally t = {0, 0};
    add(&t, 4 * h * across, h * h / 3);
    add(&t, 4 * across * r, beyond(h, r / 2, r * r / 3));
    add(&t, 4 * h * r, h * h / 3);
    add(&t, pi * r * r, beyond(h, 4 * r / (3 * pi), r * r / 4));
    return t.squares / t.volume;
}

static double mean_square_3d(double h, double a, double b, double r)
{
    tally t = {0, 0};
    add(&t, 8 * h * a * b, h * h / 3);
    add(&t, 8 * a * b * r, beyond(h, r / 2, r * r / 3));
    add(&t, 8 * h * (a + b) * r, h * h / 3);
    add(&t, 2 * pi * r * r * h, h * h / 3);
    add(&t, 2 * pi * r * r * (a + b), beyond(h, 4 * r / (3 * pi), r * r / 4));
    add(&t, 4 * pi * r * r * r / 3, beyond(h, 3 * r / 8, r * r / 5));
    return t.squares / t.volume;
}

// The mean of x^2, y^2 and z^2 over a solid rounded box of one density, along its own axes; of a
// disc or rounded rectangle in 2D, where z^2 is 0. The radius is above 0.
static void rounded_spread(const float h[3], float radius, uint32_t dims, double spread[3])
{
    for (uint32_t k = 0; k < dims; ++k)
        spread[k] = dims == 2 ? mean_square_2d((double)h[k], (double)h[1 - k], (double)radius)
                              : mean_square_3d((double)h[k], (double)h[(k + 1) % 3],
                                               (double)h[(k + 2) % 3], (double)radius);
}

static double inverse_of(double inertia)
{
    return inertia > 0.0 ? 1.0 / inertia : 0.0;
}

void inertia_inverse(const float h[3], float radius, double mass, uint32_t dims, double inverse[3])
{
    bool solid = dims == 3;
    double spread[3] = {0};
    if (radius > 0.0f) {
        rounded_spread(h, radius, dims, spread);
    } else {
        mass /= 3.0;
        for (int k = 0; k < 3; ++k)
            spread[k] = (double)h[k] * h[k];
    }
    inverse[0] = solid ? inverse_of(mass * (spread[1] + spread[2])) : 0.0;
    inverse[1] = solid ? inverse_of(mass * (spread[0] + spread[2])) : 0.0;
    inverse[2] = inverse_of(mass * (spread[0] + spread[1]));
}
