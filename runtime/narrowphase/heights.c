// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/heights.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- checks

static bool is_between(double value, double least, double most)
{
    return value >= least && value <= most;
}

static bool check_grid(const duet_heights *h, duet_error *err)
{
    if (h->nx < 2 || h->ny < 2 || (uint64_t)h->nx * h->ny > DUET_MOST_HEIGHTS)
        return bad_argument(
            err,
            "the ground has %u x %u heights; expected 2 or more along each axis, and %u at most",
            h->nx, h->ny, DUET_MOST_HEIGHTS);
    for (int k = 0; k < 3; ++k)
        if (!is_between(h->origin[k], -1e30, 1e30))
            return bad_argument(err, "%c of the ground's origin is %g; expected from -1e30 to 1e30",
                                "xyz"[k], h -> origin[k]);
    for (int k = 0; k < 2; ++k)
        if (!is_between(h->spacing[k], 1e-6, 1e6))
            return bad_argument(err,
                                "the ground's spacing along %c is %g; expected from 1e-6 to 1e6",
                                "xy"[k], h -> spacing[k]);
    return true;
}

bool heights_check(const duet_heights *h, duet_error *err)
{
    if (!check_grid(h, err))
        return false;
    if (!h->heights)
        return bad_argument(err, "the ground's heights are NULL");
    for (uint32_t i = 0; i < h->nx * h->ny; ++i)
        if (!is_between((double)h->heights[i], -1e15, 1e15))
            return bad_argument(err,
                                "height %u, %u of the ground is %g; expected from -1e15 to 1e15",
                                i % h->nx, i / h->nx, (double)h->heights[i]);
    return true;
}

bool heights_check_places(const duet_heights *h, duet_error *err)
{
    for (int k = 0; k < 2; ++k)
        if (fabs(h->origin[k]) > 0x1p40 * h->spacing[k])
            return bad_argument(err,
                                "the ground's origin is %g along %c; expected at most 2^40 times "
                                "its spacing of %g, for queries",
                                h->origin[k], "xy"[k], h -> spacing[k]);
    return true;
}

size_t heights_bytes(const duet_heights *h)
{
    return (size_t)h->nx * h->ny * sizeof *h->heights;
}

bool heights_copy(duet_heights *to, const duet_heights *h, duet_error *err)
{
    const size_t bytes = heights_bytes(h);
    float *values = malloc(bytes);
    if (!values)
        return no_memory(err, "a ground of %zu bytes", bytes);
    *to = *h;
    to->heights = memcpy(values, h->heights, bytes);
    return true;
}

void heights_place(const duet_heights *h, uint32_t i, uint32_t j, double at[3])
{
    at[0] = fma(i, h->spacing[0], h->origin[0]);
    at[1] = fma(j, h->spacing[1], h->origin[1]);
    at[2] = h->origin[2] + (double)h->heights[(size_t)j * h->nx + i];
}

//   c --- d     a b d is the lower triangle of a cell, a d c the upper one
//   |   / |
//   | /   |
//   a --- b
ground_piece heights_piece(const duet_heights *h, uint32_t i, uint32_t j, bool upper)
{
    ground_piece p = {.is_rim = {!upper && j == 0, upper ? j + 2 == h->ny : i + 2 == h->nx,
                                 upper && i == 0, false}};
    heights_place(h, i, j, p.corner[0]);
    heights_place(h, i + 1, upper ? j + 1 : j, p.corner[1]);
    heights_place(h, upper ? i : i + 1, j + 1, p.corner[2]);
    return p;
}
