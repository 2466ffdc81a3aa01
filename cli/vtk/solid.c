// SPDX-License-Identifier: MIT
#include "cli/vtk/solid.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

// Kinds of cells, by VTK's numbers.
enum { CELL_POLYGON = 7, CELL_QUAD = 9, CELL_HEXAHEDRON = 12, CELL_POLYHEDRON = 42 };
// Edges of a quarter turn; in 2D, where a body is one outline, more.
enum { ROUND = 3, ROUND_2D = 8, BOX = 8 };

// The axes along which the core has an extent, bit by bit; or BOX.
uint32_t solid_kind(const duet_rounded_box *box, uint32_t dims)
{
    uint32_t kind = 0;
    for (uint32_t k = 0; k < dims; ++k)
        kind |= (box->pose.half_extents[k] > 0.0f ? 1u : 0u) << k;
    return box->radius > 0.0f ? kind : BOX;
}

// ---------------------------------------------------------------- boxes

static void make_box(solid *s, uint32_t dims)
{
    static const int8_t square[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    *s = (solid){.cell = dims == 3 ? CELL_HEXAHEDRON : CELL_QUAD, .n_points = dims == 3 ? 8 : 4};
    for (uint32_t i = 0; i < s->n_points; ++i) {
        int8_t *side = s->points[i].side;
        memcpy(side, square[i % 4], sizeof square[0]);
        side[2] = dims == 2 ? 0 : i < 4 ? -1 : 1;
    }
}

// ---------------------------------------------------------------- 2D

// Whole quarters of a circle; the next one's first point is the last of this one if the core has
// no extent between them.
static void make_outline(solid *s, uint32_t kind)
{
    static const int8_t sides[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    const double step = acos(-1) / 2 / ROUND_2D;
    *s = (solid){.cell = CELL_POLYGON};
    for (int quarter = 0; quarter < 4; ++quarter) {
        int last = kind >> quarter % 2 & 1 ? ROUND_2D : ROUND_2D - 1;
        for (int i = 0; i <= last; ++i) {
            solid_point *p = &s->points[s->n_points++];
            for (int k = 0; k < 2; ++k)
                p->side[k] = kind >> k & 1 ? sides[quarter][k] : 0;
            p->out[0] = cos((quarter * ROUND_2D + i) * step);
            p->out[1] = sin((quarter * ROUND_2D + i) * step);
        }
    }
}

// ---------------------------------------------------------------- 3D

// A point of an octant's net: whole numbers whose sum is ROUND, each with its axis's sign.
typedef struct net_point {
    int at[3];
    int side[3];
} net_point;

// Points are even on the edges of an octant.
static void find_direction(const net_point *p, double out[3])
{
    double length = 0;
    for (int k = 0; k < 3; ++k) {
        out[k] = sin(acos(-1) / 2 * p->at[k] / ROUND);
        length = hypot(length, out[k]);
    }
    for (int k = 0; k < 3; ++k)
        out[k] /= length;
}

static bool is_same(const solid_point *p, const solid_point *q)
{
    double apart = 0;
    for (int k = 0; k < 3; ++k)
        apart += fabs(p->out[k] - q->out[k]) + abs(p->side[k] - q->side[k]);
    return apart < 1e-9;
}

// The number of a point, which is added when it is first asked for.
static uint8_t point_at(solid *s, uint32_t kind, const net_point *from)
{
    solid_point p = {0};
    find_direction(from, p.out);
    for (int k = 0; k < 3; ++k)
        p.side[k] = kind >> k & 1 ? (int8_t)from->side[k] : 0;
    uint32_t i = 0;
    while (i < s->n_points && !is_same(&s->points[i], &p))
        ++i;
    if (i == s->n_points)
        s->points[s->n_points++] = p;
    return (uint8_t)i;
}

// The points go round to the left as they are seen from outside, or to the right if `turned`.
static void add_face(solid *s, uint32_t kind, const net_point *points, int n, bool turned)
{
    s->words[s->n_words++] = (uint8_t)n;
    for (int i = 0; i < n; ++i)
        s->words[s->n_words++] = point_at(s, kind, &points[turned ? n - 1 - i : i]);
    ++s->n_faces;
}

static net_point in_octant(const int side[3], int i, int j)
{
    const int at[3] = {i, j, ROUND - i - j};
    net_point p;
    for (int k = 0; k < 3; ++k) {
        p.side[k] = side[k];
        p.at[k] = side[k] * at[k];
    }
    return p;
}

static void add_corner(solid *s, uint32_t kind, const int side[3])
{
    bool turned = side[0] * side[1] * side[2] < 0;
    for (int i = 0; i < ROUND; ++i)
        for (int j = 0; i + j < ROUND; ++j) {
            const net_point right = in_octant(side, i + 1, j), left = in_octant(side, i, j + 1);
            const net_point up[3] = {in_octant(side, i, j), right, left};
            const net_point down[3] = {right, in_octant(side, i + 1, j + 1), left};
            add_face(s, kind, up, 3, turned);
            if (i + j + 1 < ROUND)
                add_face(s, kind, down, 3, turned);
        }
}

// A quarter of a cylinder along an axis.
static void add_edge(solid *s, uint32_t kind, int axis, int side_a, int side_b)
{
    int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int i = 0; i < ROUND; ++i) {
        net_point quad[4] = {{{0}, {0}}};
        for (int k = 0; k < 4; ++k) {
            int along = k == 1 || k == 2 ? i + 1 : i;
            quad[k].side[a] = side_a;
            quad[k].side[b] = side_b;
            quad[k].side[axis] = k < 2 ? -1 : 1;
            quad[k].at[a] = side_a * (ROUND - along);
            quad[k].at[b] = side_b * along;
        }
        add_face(s, kind, quad, 4, side_a * side_b < 0);
    }
}

static void add_flat(solid *s, uint32_t kind, int axis, int side)
{
    static const int square[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    net_point quad[4] = {{{0}, {0}}};
    for (int k = 0; k < 4; ++k) {
        quad[k].side[axis] = side;
        quad[k].at[axis] = side * ROUND;
        quad[k].side[(axis + 1) % 3] = square[k][0];
        quad[k].side[(axis + 2) % 3] = square[k][1];
    }
    add_face(s, kind, quad, 4, side < 0);
}

// Corners meet where the core has no extent; edges and flat faces are then left out.
static void make_rounded(solid *s, uint32_t kind)
{
    *s = (solid){.cell = CELL_POLYHEDRON};
    for (int corner = 0; corner < 8; ++corner)
        add_corner(s, kind,
                   (int[3]){corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1});
    for (int axis = 0; axis < 3; ++axis) {
        bool along = kind >> axis & 1;
        bool wide = (kind | 1u << axis) == 7;
        for (int i = 0; along && i < 4; ++i)
            add_edge(s, kind, axis, i & 1 ? 1 : -1, i & 2 ? 1 : -1);
        for (int side = -1; wide && side < 2; side += 2)
            add_flat(s, kind, axis, side);
    }
}

void solids_make(solid solids[SOLID_KINDS], uint32_t dims)
{
    for (uint32_t kind = 0; kind < BOX; ++kind)
        if (dims == 3)
            make_rounded(&solids[kind], kind);
        else
            make_outline(&solids[kind], kind);
    make_box(&solids[BOX], dims);
}

// ---------------------------------------------------------------- on a body

// The columns are the body's axes.
static void turn_of(const double q[4], double turn[3][3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double m[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
    };
    memcpy(turn, m, sizeof m);
}

void solid_place(const solid *s, const duet_rounded_box *box, const duet_state *state,
                 double (*at)[3])
{
    double turn[3][3];
    turn_of(state->rotation, turn);
    for (uint32_t i = 0; i < s->n_points; ++i) {
        double from[3];
        for (int k = 0; k < 3; ++k)
            from[k] = (double)s->points[i].side[k] * (double)box->pose.half_extents[k] +
                      (double)box->radius * s->points[i].out[k];
        for (int k = 0; k < 3; ++k)
            at[i][k] = state->centre[k] + turn[k][0] * from[0] + turn[k][1] * from[1] +
                       turn[k][2] * from[2];
    }
}
