// SPDX-License-Identifier: MIT
#include "runtime/grid.h"

#include <math.h>
#include <stdbool.h>

// Dense cell starts cost four bytes a cell; four cells an object keep them
// below a tenth of what an object itself takes.
static const double cells_per_object = 4.0;
static const double most_along = 65536.0;

static grid_needs no_needs(void)
{
    return (grid_needs){
        .lower = {INFINITY, INFINITY, INFINITY},
        .upper = {-INFINITY, -INFINITY, -INFINITY},
    };
}

static void add_needs(grid_needs *needs, const double centre[3], double widest, uint32_t id,
                      uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k) {
        needs->lower[k] = fmin(needs->lower[k], centre[k]);
        needs->upper[k] = fmax(needs->upper[k], centre[k]);
    }
    if (widest > needs->widest) {
        needs->widest = widest;
        needs->widest_id = id;
    }
}

// The widest extent of the rotated box: rows of |M(q)| / |q|^2 times the half
// extents, twice.
static double widest_of_pose(const duet_pose *p, uint32_t dims)
{
    double x = dims == 3 ? p->rotation[0] : 0.0;
    double y = dims == 3 ? p->rotation[1] : 0.0;
    double z = p->rotation[2];
    double w = p->rotation[3];
    double hx = p->half[0];
    double hy = p->half[1];
    double hz = dims == 3 ? p->half[2] : 0.0;
    double scale = 2.0 / (x * x + y * y + z * z + w * w);
    double rx = fabs(w * w + x * x - y * y - z * z) * hx + 2.0 * fabs(x * y - w * z) * hy +
                2.0 * fabs(x * z + w * y) * hz;
    double ry = 2.0 * fabs(x * y + w * z) * hx + fabs(w * w - x * x + y * y - z * z) * hy +
                2.0 * fabs(y * z - w * x) * hz;
    double rz = 2.0 * fabs(x * z - w * y) * hx + 2.0 * fabs(y * z + w * x) * hy +
                fabs(w * w - x * x - y * y + z * z) * hz;
    double widest = fmax(rx, ry);
    return scale * (dims == 3 ? fmax(widest, rz) : widest);
}

grid_needs grid_needs_of_poses(const duet_pose *poses, uint32_t n, uint32_t dims)
{
    grid_needs needs = no_needs();
    for (uint32_t id = 0; id < n; ++id) {
        const duet_pose *p = &poses[id];
        double centre[3] = {p->centre[0], p->centre[1], dims == 3 ? p->centre[2] : 0.0};
        double widest = widest_of_pose(p, dims);
        if (isfinite(centre[0] + centre[1] + centre[2] + widest))
            add_needs(&needs, centre, widest, id, dims);
    }
    return needs;
}

grid_needs grid_needs_of_bounds(const duet_bounds *bounds, uint32_t n, uint32_t dims)
{
    grid_needs needs = no_needs();
    for (uint32_t id = 0; id < n; ++id) {
        const duet_bounds *b = &bounds[id];
        double centre[3] = {0.0, 0.0, 0.0};
        double widest = 0.0;
        for (uint32_t k = 0; k < dims; ++k) {
            centre[k] = 0.5 * ((double)b->lower[k] + (double)b->upper[k]);
            widest = fmax(widest, (double)b->upper[k] - (double)b->lower[k]);
        }
        if (isfinite(centre[0] + centre[1] + centre[2] + widest))
            add_needs(&needs, centre, widest, id, dims);
    }
    return needs;
}

static double margin(double cells)
{
    return 1.0 + 0x1p-16 + cells * 0x1p-21;
}

// As many cells as hold the edge with its margin.
static double count_along(double length, double edge)
{
    double most = edge > 0.0 ? fmin(length / edge, most_along) : most_along;
    double cells = edge > 0.0 ? floor(length / (edge * margin(most))) : most_along;
    return fmax(1.0, fmin(cells, most_along));
}

// Widens the edge until the cells are few enough.
static void choose_cells(grid *g, const double length[3], double edge, double most, uint32_t dims)
{
    for (;;) {
        double total = 1.0;
        for (uint32_t k = 0; k < 3; ++k) {
            double along = k < dims ? count_along(length[k], edge) : 1.0;
            g->cells[k] = (uint32_t)along;
            total *= along;
        }
        if (total <= most) {
            g->n_cells = (uint32_t)total;
            return;
        }
        double longest = fmax(length[0], fmax(length[1], dims == 3 ? length[2] : 0.0));
        edge = fmax(edge * 1.1, longest / most_along);
    }
}

grid grid_fit(const double lower[3], const double upper[3], double edge, uint32_t n, uint32_t dims)
{
    grid g = {.n_cells = 1, .cells = {1, 1, 1}};
    double length[3] = {0.0, 0.0, 0.0};
    for (uint32_t k = 0; k < dims; ++k)
        length[k] = upper[k] > lower[k] ? upper[k] - lower[k] : 0.0;
    double most = fmin(cells_per_object * n + 64.0, 0x1p31);
    choose_cells(&g, length, edge, most, dims);
    g.edge = INFINITY;
    for (uint32_t k = 0; k < dims; ++k) {
        double along = fmax(length[k] / g.cells[k], edge * margin(g.cells[k]));
        if (!(along > 0.0)) // points in one place
            along = 1.0;
        g.lower.s[k] = length[k] > 0.0 || isfinite(lower[k]) ? (float)lower[k] : 0.0f;
        g.per_cell.s[k] = (float)(1.0 / along);
        g.limit.s[k] = g.cells[k] == 1 ? INFINITY : (float)(along / margin(g.cells[k]));
        g.edge = fminf(g.edge, (float)along);
    }
    while (g.key_bits < 32 && g.n_cells >> g.key_bits)
        ++g.key_bits;
    return g;
}
