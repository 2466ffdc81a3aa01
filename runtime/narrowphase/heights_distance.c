// SPDX-License-Identifier: MIT
// How far a point is from a ground: from a triangle, or level from a wall of the rim. Cells that
// are further away than what was found are left out.
#include "runtime/narrowphase/heights.h"

#include <math.h>

typedef struct search {
    const duet_heights *heights;
    double at[3];
    double square; // of the least distance so far
} search;

// ---------------------------------------------------------------- walls

// The wall under an edge of the rim from a to b, which lies along an axis: level with the point.
static double square_to_wall(const double a[3], const double b[3], int axis, const double at[3])
{
    double along = fmin(fmax(at[axis], a[axis]), b[axis]);
    double part = (along - a[axis]) / (b[axis] - a[axis]), gap = at[axis] - along;
    double beside = at[!axis] - a[!axis];
    bool is_wall = at[2] <= a[2] + part * (b[2] - a[2]);
    return is_wall ? gap * gap + beside * beside : INFINITY;
}

// All walls along an axis, on the side of the grid where the other axis has the place `other`.
static void search_walls(search *s, int axis, uint32_t other)
{
    const duet_heights *h = s->heights;
    uint32_t n = axis == 0 ? h->nx : h->ny;
    for (uint32_t i = 0; i + 1 < n; ++i) {
        double a[3], b[3];
        heights_place(h, axis == 0 ? i : other, axis == 0 ? other : i, a);
        heights_place(h, axis == 0 ? i + 1 : other, axis == 0 ? other : i + 1, b);
        s->square = fmin(s->square, square_to_wall(a, b, axis, s->at));
    }
}

// ---------------------------------------------------------------- cells

// How far a point is from what lies between two places along an axis.
static double beyond(const search *s, int axis, uint32_t first, uint32_t last)
{
    const duet_heights *h = s->heights;
    double lower = fma(first, h->spacing[axis], h->origin[axis]);
    double upper = fma(last, h->spacing[axis], h->origin[axis]);
    return fmax(0.0, fmax(lower - s->at[axis], s->at[axis] - upper));
}

static void search_cell(search *s, uint32_t i, uint32_t j)
{
    for (int upper = 0; upper < 2; ++upper) {
        const ground_piece p = heights_piece(s->heights, i, j, upper);
        s->square = fmin(s->square, ground_piece_square(&p, s->at));
    }
}

static uint32_t cell_at(const search *s, int axis)
{
    const duet_heights *h = s->heights;
    double at = floor((s->at[axis] - h->origin[axis]) / h->spacing[axis]);
    return (uint32_t)fmin(fmax(at, 0.0), (axis == 0 ? h->nx : h->ny) - 2.0);
}

static bool is_near(const search *s, double gap, double beside)
{
    return gap * gap + beside * beside <= s->square;
}

// A row of cells, from the nearest one to both sides.
static void search_row(search *s, uint32_t j)
{
    uint32_t middle = cell_at(s, 0);
    double gap = beyond(s, 1, j, j + 1);
    for (uint32_t i = middle; i + 1 < s->heights->nx; ++i) {
        if (!is_near(s, beyond(s, 0, i, i + 1), gap))
            break;
        search_cell(s, i, j);
    }
    for (uint32_t i = middle; i-- > 0;) {
        if (!is_near(s, beyond(s, 0, i, i + 1), gap))
            break;
        search_cell(s, i, j);
    }
}

static void search_cells(search *s)
{
    uint32_t middle = cell_at(s, 1);
    for (uint32_t j = middle; j + 1 < s->heights->ny && is_near(s, beyond(s, 1, j, j + 1), 0.0);
         ++j)
        search_row(s, j);
    for (uint32_t j = middle; j-- > 0 && is_near(s, beyond(s, 1, j, j + 1), 0.0);)
        search_row(s, j);
}

double heights_distance(const duet_heights *h, const float at[3])
{
    search s = {.heights = h, .at = {at[0], at[1], at[2]}, .square = INFINITY};
    for (int k = 0; k < 2; ++k) {
        uint32_t last = (k == 0 ? h->nx : h->ny) - 1;
        if (beyond(&s, k, 0, last) > 0.0)
            search_walls(&s, !k, s.at[k] < h->origin[k] ? 0 : last);
    }
    search_cells(&s);
    return sqrt(s.square);
}
