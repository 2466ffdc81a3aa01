// SPDX-License-Identifier: MIT
#include "cli/draw/relief.h"

#include "base/error.h"
#include "runtime/narrowphase/mesh.h"

#include <math.h>
#include <stdlib.h>

enum {
    MOST_CELLS = 256, // drawn along an axis
    PIECES = 24       // that cut a triangle as long as what is shown
};

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

static void add_heights(const duet_heights *h, const extent *about, extent *part)
{
    uint32_t across[2], along[2];
    find_places(h, 0, about, across);
    find_places(h, 1, about, along);
    for (uint32_t j = along[0]; j <= along[1]; ++j)
        for (uint32_t i = across[0]; i <= across[1]; ++i) {
            double at[3];
            place_of(h, i, j, at);
            extent_add(part, at);
        }
}

static bool is_in(const extent *e, const double at[3])
{
    bool in = true;
    for (int k = 0; k < 3; ++k)
        in = in && at[k] >= e->lower[k] && at[k] <= e->upper[k];
    return in;
}

static void add_mesh(const duet_mesh *m, const extent *about, extent *part)
{
    for (uint32_t i = 0; i < 3 * m->n_triangles; ++i) {
        double at[3];
        mesh_place(m, i / 3, i % 3, at);
        if (is_in(about, at))
            extent_add(part, at);
    }
}

// All of a ground that reaches no further than half the part's width.
void relief_widen(const duet_motion_def *def, extent *part)
{
    double wide = fmax(part->upper[0] - part->lower[0], part->upper[1] - part->lower[1]);
    extent about = *part;
    for (int k = 0; k < 3; ++k) {
        about.lower[k] -= wide / 2;
        about.upper[k] += wide / 2;
    }
    if (def->heights)
        add_heights(def->heights, &about, part);
    if (def->mesh)
        add_mesh(def->mesh, &about, part);
}

static double nearness_of(const relief *r, const double at[3])
{
    return view_nearness(r->view, (const double[3]){at[0], at[1], r->is_level ? 0 : at[2]});
}

double relief_nearness(const relief *r, const corners *box)
{
    const double *near = r->view->look->near;
    double nearest = -INFINITY;
    for (int i = 0; i < 8; ++i)
        nearest = fmax(nearest, nearness_of(r, box->at[i]));
    return nearest + box->radius * hypot(hypot(near[0], near[1]), r->is_level ? 0 : near[2]);
}

// ---------------------------------------------------------------- triangles

static int from_far_to_near(const void *x, const void *y)
{
    const relief_triangle *a = x, *b = y;
    if (a->nearness != b->nearness)
        return a->nearness < b->nearness ? -1 : 1;
    return (a->order > b->order) - (a->order < b->order);
}

static bool reserve(relief *r, size_t most, duet_error *err)
{
    r->triangles = malloc(most * sizeof *r->triangles);
    return r->triangles || no_memory(err, "a picture of a ground");
}

static void add_triangle(relief *r, const double *a, const double *b, const double *d,
                         double nearness)
{
    relief_triangle *t = &r->triangles[r->n];
    *t = (relief_triangle){.nearness = nearness, .order = r->n++};
    for (int k = 0; k < 3; ++k) {
        t->at[0][k] = a[k];
        t->at[1][k] = b[k];
        t->at[2][k] = d[k];
    }
}

static uint32_t next_place(uint32_t at, uint32_t step, uint32_t n)
{
    return at + step < n - 1 ? at + step : n - 1;
}

// The triangle with the corner of least x and most y is the farther one: the eye stands at great x
// and small y.
static void add_cell(relief *r, const duet_heights *h, uint32_t step, uint32_t i, uint32_t j)
{
    double at[4][3], farthest = INFINITY;
    for (uint32_t k = 0; k < 4; ++k) {
        place_of(h, k & 1 ? next_place(i, step, h->nx) : i, k & 2 ? next_place(j, step, h->ny) : j,
                 at[k]);
        farthest = fmin(farthest, nearness_of(r, at[k]));
    }
    add_triangle(r, at[0], at[3], at[2], farthest);
    add_triangle(r, at[0], at[1], at[3], farthest);
}

static bool take_heights(relief *r, const duet_heights *h, duet_error *err)
{
    uint32_t longest = h->nx > h->ny ? h->nx : h->ny;
    uint32_t step = 1 + (longest - 2) / MOST_CELLS;
    size_t cells = ((h->nx - 2) / step + 1) * (size_t)((h->ny - 2) / step + 1);
    r->is_level = true;
    if (!reserve(r, 2 * cells, err))
        return false;
    for (uint32_t j = 0; j < h->ny - 1; j += step)
        for (uint32_t i = 0; i < h->nx - 1; i += step)
            add_cell(r, h, step, i, j);
    return true;
}

// Pieces along each side of a triangle of a mesh, so that what stands before one end of it may
// hide it, and what stands behind the other be hidden.
static uint32_t pieces_along(const relief *r, const duet_mesh *m, uint32_t triangle)
{
    const extent *shown = &r->view->shown;
    double square = 0.0, longest = 0.0, most = fmax(1.0, MOST_CELLS / sqrt(m->n_triangles));
    for (int k = 0; k < 3; ++k)
        square += (shown->upper[k] - shown->lower[k]) * (shown->upper[k] - shown->lower[k]);
    for (uint32_t e = 0; e < 3; ++e) {
        double a[3], b[3];
        mesh_place(m, triangle, e, a);
        mesh_place(m, triangle, (e + 1) % 3, b);
        longest = fmax(longest, hypot(hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]));
    }
    return (uint32_t)fmin(most, fmax(1.0, ceil(PIECES * longest / sqrt(square))));
}

// A place of a triangle that is i and j of n pieces from its first corner.
static void place_in(double at[3][3], uint32_t n, uint32_t i, uint32_t j, double out[3])
{
    for (int k = 0; k < 3; ++k)
        out[k] = at[0][k] + (at[1][k] - at[0][k]) * i / n + (at[2][k] - at[0][k]) * j / n;
}

static void add_piece(relief *r, double at[3][3], uint32_t n, uint32_t i, uint32_t j, bool is_outer)
{
    double corner[3][3], farthest = INFINITY;
    place_in(at, n, i + 1, j, corner[0]);
    place_in(at, n, is_outer ? i + 1 : i, j + 1, corner[1]);
    place_in(at, n, i, is_outer ? j + 1 : j, corner[2]);
    for (int k = 0; k < 3; ++k)
        farthest = fmin(farthest, nearness_of(r, corner[k]));
    add_triangle(r, corner[0], corner[1], corner[2], farthest);
}

static void add_pieces(relief *r, const duet_mesh *m, uint32_t triangle)
{
    uint32_t n = pieces_along(r, m, triangle);
    double at[3][3];
    for (uint32_t k = 0; k < 3; ++k)
        mesh_place(m, triangle, k, at[k]);
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; i + j < n; ++j) {
            add_piece(r, at, n, i, j, false);
            if (i + j + 1 < n)
                add_piece(r, at, n, i, j, true);
        }
}

static bool take_mesh(relief *r, const duet_mesh *m, duet_error *err)
{
    size_t pieces = 0;
    for (uint32_t i = 0; i < m->n_triangles; ++i) {
        size_t n = pieces_along(r, m, i);
        pieces += n * n;
    }
    if (!reserve(r, pieces, err))
        return false;
    for (uint32_t i = 0; i < m->n_triangles; ++i)
        add_pieces(r, m, i);
    return true;
}

bool relief_begin(relief *r, const duet_motion_def *def, const view *v, duet_error *err)
{
    *r = (relief){.view = v};
    if ((def->heights && !take_heights(r, def->heights, err)) ||
        (def->mesh && !take_mesh(r, def->mesh, err)))
        return false;
    if (r->triangles)
        qsort(r->triangles, r->n, sizeof *r->triangles, from_far_to_near);
    return true;
}

void relief_end(relief *r)
{
    free(r->triangles);
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

// A triangle that turns away from the eye shows nothing.
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

void relief_draw(relief *r, canvas *c, double nearness)
{
    for (; r->n_drawn < r->n && r->triangles[r->n_drawn].nearness < nearness; ++r->n_drawn) {
        const relief_triangle *t = &r->triangles[r->n_drawn];
        draw_triangle(r->view, c, t->at[0], t->at[1], t->at[2]);
    }
}
