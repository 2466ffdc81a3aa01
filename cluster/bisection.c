// SPDX-License-Identifier: MIT
#include "cluster/bisection.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

bool bisection_begin(bisection *b, uint32_t n, duet_error *err)
{
    *b = (bisection){.n = n, .planes = malloc((size_t)n * sizeof *b->planes)};
    for (uint32_t i = 0; b->planes && i < n; ++i)
        b->planes[i] = (bisection_plane){INFINITY, 0};
    return b->planes || no_memory(err, "%" PRIu32 " parts", n);
}

void bisection_end(bisection *b)
{
    free(b->planes);
    *b = (bisection){0};
}

// A last cut across a side that is at least this part of the widest one stays across it: else half
// of the points would change parts as sides of almost one width take turns.
static const double wide_enough = 0.95;

static double width_along(const bisection_point *points, uint64_t n, uint32_t axis)
{
    double least = INFINITY, greatest = -INFINITY;
    for (uint64_t i = 0; i < n; ++i) {
        least = fmin(least, points[i].at[axis]);
        greatest = fmax(greatest, points[i].at[axis]);
    }
    return greatest - least;
}

static uint32_t choose_axis(const bisection_plane *last, const bisection_point *points, uint64_t n)
{
    double widths[3];
    uint32_t widest = 0;
    for (uint32_t k = 0; k < 3; ++k) {
        widths[k] = width_along(points, n, k);
        widest = widths[k] > widths[widest] ? k : widest;
    }
    const bool stays = isfinite(last->at) && widths[last->axis] >= wide_enough * widths[widest];
    return stays ? last->axis : widest;
}

static int compare(double a, double b)
{
    return (a > b) - (a < b);
}

static int along_x(const void *a, const void *b)
{
    return compare(((const bisection_point *)a)->at[0], ((const bisection_point *)b)->at[0]);
}

static int along_y(const void *a, const void *b)
{
    return compare(((const bisection_point *)a)->at[1], ((const bisection_point *)b)->at[1]);
}

static int along_z(const void *a, const void *b)
{
    return compare(((const bisection_point *)a)->at[2], ((const bisection_point *)b)->at[2]);
}

// How many sorted points lie below the plane that leaves nearest to `due` of their weight there. It
// is no plane if points before and after it lie on it.
static uint64_t find_split(const bisection_point *points, uint64_t n, uint32_t axis, double due)
{
    uint64_t best = 0;
    double below = 0, nearest = due;
    for (uint64_t i = 1; i <= n; ++i) {
        below += points[i - 1].weight;
        if (i < n && points[i].at[axis] == points[i - 1].at[axis])
            continue;
        if (fabs(below - due) < nearest) {
            nearest = fabs(below - due);
            best = i;
        }
    }
    return best;
}

static double sum_of_weights(const double *weights, uint32_t first, uint32_t end)
{
    double sum = 0;
    for (uint32_t part = first; part < end; ++part)
        sum += weights ? weights[part] : 1;
    return sum;
}

static void cut_in_two(bisection *b, const double *weights, bisection_point *points, uint64_t n,
                       uint32_t first, uint32_t end)
{
    static int (*const along[])(const void *, const void *) = {along_x, along_y, along_z};
    if (end - first < 2)
        return;
    const uint32_t middle = first + (end - first) / 2;
    const uint32_t axis = choose_axis(&b->planes[middle], points, n);
    double lower = sum_of_weights(weights, first, middle);
    double upper = sum_of_weights(weights, middle, end), all = 0;
    for (uint64_t i = 0; i < n; ++i)
        all += points[i].weight;
    qsort(points, n, sizeof *points, along[axis]);
    uint64_t split = find_split(points, n, axis, all * (lower / (lower + upper)));
    b->planes[middle] = (bisection_plane){split < n ? points[split].at[axis] : INFINITY, axis};
    cut_in_two(b, weights, points, split, first, middle);
    cut_in_two(b, weights, points + split, n - split, middle, end);
}

void bisection_cut(bisection *b, const double *weights, bisection_point *points, uint64_t n_points)
{
    cut_in_two(b, weights, points, n_points, 0, b->n);
}

extent bisection_box(const bisection *b, uint32_t part, const extent *within)
{
    extent box = *within;
    uint32_t first = 0, end = b->n;
    while (end - first > 1) {
        uint32_t middle = first + (end - first) / 2;
        const bisection_plane *plane = &b->planes[middle];
        double *low = &box.lower[plane->axis], *high = &box.upper[plane->axis];
        *(part < middle ? &end : &first) = middle;
        if (part < middle) // a half without points is cut where it has none
            *high = lesser(*high, plane->at);
        else
            *low = greater(*low, plane->at);
    }
    return box;
}
