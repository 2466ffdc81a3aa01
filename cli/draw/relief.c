// SPDX-License-Identifier: MIT
#include "cli/draw/relief.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_CELLS = 256 }; // drawn along an axis

static const colour earth = {0.80, 0.77, 0.68, 1};

static void place_of(const duet_heights *h, uint32_t i, uint32_t j, double at[3])
{
    at[0] = h->origin[0] + i * h->spacing[0];
    at[1] = h->origin[1] + j * h->spacing[1];
    at[2] = h->origin[2] + (double)h->heights[(size_t)j * h->nx + i];
}

// ---------------------------------------------------------------- what is seen

// The places along an axis from a lower to an upper bound.
static void find_places(const duet_heights *h, int axis, const extent *part, uint32_t range[2])
{
    uint32_t last = (axis == 0 ? h->nx : h->ny) - 1;
    double lower = (part->lower[axis] - h->origin[axis]) / h->spacing[axis];
    double upper = (part->upper[axis] - h->origin[axis]) / h->spacing[axis];
    range[0] = (uint32_t)fmin(fmax(floor(lower), 0), last);
    range[1] = (uint32_t)fmin(fmax(ceil(upper), 0), last);
}

// All of a ground that reaches no further than half the part's width.
void relief_widen(const duet_heights *h, extent *part)
{
    if (!h)
        return;
    double wide = fmax(part->upper[0] - part->lower[0], part->upper[1] - part->lower[1]);
    extent about = *part;
    uint32_t across[2], along[2];
    for (int k = 0; k < 2; ++k) {
        about.lower[k] -= wide / 2;
        about.upper[k] += wide / 2;
    }
    find_places(h, 0, &about, across);
    find_places(h, 1, &about, along);
    for (uint32_t j = along[0]; j <= along[1]; ++j)
        for (uint32_t i = across[0]; i <= across[1]; ++i) {
            double at[3];
            place_of(h, i, j, at);
            extent_add(part, at);
        }
}

static double level_nearness(const view *v, const double at[3])
{
    return view_nearness(v, (const double[3]){at[0], at[1], 0});
}

double relief_nearness(const view *v, const corners *box)
{
    double nearest = -INFINITY;
    for (int i = 0; i < 8; ++i)
        nearest = fmax(nearest, level_nearness(v, box->at[i]));
    return nearest + box->radius * hypot(v->look->near[0], v->look->near[1]);
}

// ---------------------------------------------------------------- cells

static uint32_t next_place(uint32_t at, uint32_t step, uint32_t n)
{
    return at + step < n - 1 ? at + step : n - 1;
}

static double farthest_of(const relief *r, uint32_t i, uint32_t j)
{
    const uint32_t is[2] = {i, next_place(i, r->step, r->heights->nx)};
    const uint32_t js[2] = {j, next_place(j, r->step, r->heights->ny)};
    double farthest = INFINITY;
    for (int k = 0; k < 4; ++k) {
        double at[3];
        place_of(r->heights, is[k & 1], js[k >> 1], at);
        farthest = fmin(farthest, level_nearness(r->view, at));
    }
    return farthest;
}

static int from_far_to_near(const void *x, const void *y)
{
    double a = ((const relief_cell *)x)->nearness, b = ((const relief_cell *)y)->nearness;
    return (a > b) - (a < b);
}

bool relief_begin(relief *r, const duet_heights *h, const view *v, duet_error *err)
{
    *r = (relief){.heights = h, .view = v};
    if (!h)
        return true;
    uint32_t longest = h->nx > h->ny ? h->nx : h->ny;
    r->step = 1 + (longest - 2) / MOST_CELLS;
    size_t most = ((h->nx - 2) / r->step + 1) * (size_t)((h->ny - 2) / r->step + 1);
    r->cells = malloc(most * sizeof *r->cells);
    if (!r->cells)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a picture of a ground");
    for (uint32_t j = 0; j < h->ny - 1; j += r->step)
        for (uint32_t i = 0; i < h->nx - 1; i += r->step)
            r->cells[r->n++] = (relief_cell){i, j, farthest_of(r, i, j)};
    qsort(r->cells, r->n, sizeof *r->cells, from_far_to_near);
    return true;
}

void relief_end(relief *r)
{
    free(r->cells);
}

// ---------------------------------------------------------------- drawing

static colour shade(const look *from, const double n[3])
{
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), lit = 0;
    for (int k = 0; k < 3; ++k)
        lit += from->light[k] * n[k] / length;
    double light = from->dark + from->bright * fmax(lit, 0);
    return (colour){earth.red * light, earth.green * light, earth.blue * light, 1};
}

// A triangle whose normal points up; one that turns away from the eye shows nothing.
static void draw_triangle(const view *v, canvas *c, const double *a, const double *b,
                          const double *d)
{
    const double p[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const double q[3] = {d[0] - a[0], d[1] - a[1], d[2] - a[2]};
    const double n[3] = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                         p[0] * q[1] - p[1] * q[0]};
    const point walk[3] = {view_point(v, a), view_point(v, b), view_point(v, d)};
    for (int i = 0; i < 3; ++i)
        if (!(fabs(walk[i].x) < 1e5 && fabs(walk[i].y) < 1e5)) // Cairo takes none further out
            return;
    colour fill = shade(v->look, n);
    if (view_nearness(v, n) > 0)
        canvas_polygon(c, walk, 3, fill, fill);
}

// The triangle with the corner of least x and most y is the farther one: the eye stands at great x
// and small y.
static void draw_cell(const relief *r, canvas *c, const relief_cell *cell)
{
    const duet_heights *h = r->heights;
    uint32_t i = next_place(cell->i, r->step, h->nx), j = next_place(cell->j, r->step, h->ny);
    double at[4][3];
    place_of(h, cell->i, cell->j, at[0]);
    place_of(h, i, cell->j, at[1]);
    place_of(h, cell->i, j, at[2]);
    place_of(h, i, j, at[3]);
    draw_triangle(r->view, c, at[0], at[3], at[2]);
    draw_triangle(r->view, c, at[0], at[1], at[3]);
}

void relief_draw(relief *r, canvas *c, double nearness)
{
    while (r->n_drawn < r->n && r->cells[r->n_drawn].nearness < nearness)
        draw_cell(r, c, &r->cells[r->n_drawn++]);
}
