// SPDX-License-Identifier: MIT
// Whether a moving box with a radius meets a piece of a ground: whether their cores, the box
// without it and the piece, come as near to each other.
//
// The distance of two convex sets that move past each other is convex. Where they are nearest, they
// come nearer no faster than along the gap: from the begin each gap leads to a later time, and
// never beyond the first at which they touch.
#include "runtime/narrowphase/ground_piece.h"
#include "runtime/narrowphase/vector.h"

#include <math.h>
#include <string.h>

enum { STEPS = 200 };

#define TOUCHING 0x1p-40 // of the sizes: nearer than the radius by rounding alone

// From a place of the piece to the nearest one of the core, both from the core's centre.
typedef struct gap {
    double way[3], square;
} gap;

// The piece, seen from the core's centre at some time, the direction of its walls, and where they
// may end: below the core.
typedef struct scene {
    const ground_probe *probe;
    bool is_sheet;
    double corner[3][3], up[3], low;
    gap best;
} scene;

static void offer(scene *s, const double on_piece[3], const double on_core[3])
{
    gap g = {.square = 0.0};
    for (int k = 0; k < 3; ++k) {
        g.way[k] = on_core[k] - on_piece[k];
        g.square += g.way[k] * g.way[k];
    }
    if (g.square < s->best.square)
        s->best = g;
}

static double clamped(double value, double lower, double upper)
{
    return fmin(fmax(value, lower), upper);
}

// ---------------------------------------------------------------- corners

static void offer_corner_of_piece(scene *s, const double at[3])
{
    double point[3] = {0};
    for (int i = 0; i < 3; ++i) {
        double along = clamped(dot(at, s->probe->axis[i]), -s->probe->half[i], s->probe->half[i]);
        for (int k = 0; k < 3; ++k)
            point[k] += along * s->probe->axis[i][k];
    }
    offer(s, at, point);
}

static void set_top(double corner[3][3], double normal[3])
{
    double e[2][3];
    for (int k = 0; k < 3; ++k) {
        e[0][k] = corner[1][k] - corner[0][k];
        e[1][k] = corner[2][k] - corner[0][k];
    }
    cross(normal, e[0], e[1]);
}

static bool is_over(const scene *s, const double foot[3])
{
    bool over = true;
    for (int i = 0; i < 3; ++i) {
        const double *a = s->corner[i], *b = s->corner[(i + 1) % 3];
        const double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const double way[3] = {foot[0] - a[0], foot[1] - a[1], foot[2] - a[2]};
        double inward[3];
        cross(inward, s->up, e);
        over = over && dot(inward, way) >= 0.0;
    }
    return over;
}

// Over the triangle its plane is nearest, and below it that of a sheet.
static void offer_top(scene *s, const double at[3])
{
    double normal[3], way[3], foot[3];
    set_top(s->corner, normal);
    for (int k = 0; k < 3; ++k)
        way[k] = at[k] - s->corner[0][k];
    double high = dot(normal, way) / dot(normal, normal);
    for (int k = 0; k < 3; ++k)
        foot[k] = at[k] - high * normal[k];
    if (is_over(s, foot))
        offer(s, foot, at);
}

// Level from a wall.
static void offer_wall(scene *s, int side, const double at[3])
{
    const double *a = s->corner[side], *b = s->corner[(side + 1) % 3];
    double e[2] = {b[0] - a[0], b[1] - a[1]}, square = e[0] * e[0] + e[1] * e[1];
    double t = clamped(((at[0] - a[0]) * e[0] + (at[1] - a[1]) * e[1]) / square, 0.0, 1.0);
    if (at[2] <= a[2] + t * (b[2] - a[2]))
        offer(s, (const double[3]){a[0] + t * e[0], a[1] + t * e[1], at[2]}, at);
}

static void offer_top_edge(scene *s, int side, const double at[3])
{
    const double *a = s->corner[side], *b = s->corner[(side + 1) % 3];
    double e[3], way[3], point[3];
    for (int k = 0; k < 3; ++k) {
        e[k] = b[k] - a[k];
        way[k] = at[k] - a[k];
    }
    double t = clamped(dot(way, e) / dot(e, e), 0.0, 1.0);
    for (int k = 0; k < 3; ++k)
        point[k] = a[k] + t * e[k];
    offer(s, point, at);
}

static void offer_corner_of_core(scene *s, const double at[3])
{
    offer_top(s, at);
    for (int side = 0; side < 3; ++side) {
        if (!s->is_sheet)
            offer_wall(s, side, at);
        offer_top_edge(s, side, at);
    }
}

// ---------------------------------------------------------------- edges

// The nearest places of two edges of any length, the first of which is none.
static void offer_edges(scene *s, const double a[3], const double b[3], const double from[3],
                        const double to[3])
{
    double d[3], e[3], way[3], on_piece[3], on_core[3];
    for (int k = 0; k < 3; ++k) {
        d[k] = b[k] - a[k];
        e[k] = to[k] - from[k];
        way[k] = a[k] - from[k];
    }
    double dd = dot(d, d), ee = dot(e, e), de = dot(d, e), dw = dot(d, way), ew = dot(e, way);
    double det = dd * ee - de * de;
    double t = det > 1e-24 * dd * ee ? clamped((de * ew - ee * dw) / det, 0.0, 1.0) : 0.0;
    double u = clamped((de * t + ew) / ee, 0.0, 1.0);
    t = clamped((de * u - dw) / dd, 0.0, 1.0);
    for (int k = 0; k < 3; ++k) {
        on_piece[k] = a[k] + t * d[k];
        on_core[k] = from[k] + u * e[k];
    }
    offer(s, on_piece, on_core);
}

static void offer_edge_of_core(scene *s, const double from[3], const double to[3])
{
    for (int i = 0; i < 3; ++i) {
        const double *a = s->corner[i];
        const double below[3] = {a[0], a[1], fmin(s->low, a[2] - 1.0)};
        offer_edges(s, a, s->corner[(i + 1) % 3], from, to);
        if (!s->is_sheet)
            offer_edges(s, a, below, from, to);
    }
}

// ---------------------------------------------------------------- all of them

// Corner `bits` of eight; false where it is another one's place.
static bool corner_of_core(const ground_probe *p, int bits, double at[3])
{
    memset(at, 0, 3 * sizeof *at);
    for (int i = 0; i < 3; ++i) {
        bool upper = bits >> i & 1;
        if (upper && p->half[i] == 0.0)
            return false;
        for (int k = 0; k < 3; ++k)
            at[k] += (upper ? p->half[i] : -p->half[i]) * p->axis[i][k];
    }
    return true;
}

static void find_gap(scene *s)
{
    const ground_probe *p = s->probe;
    double at[3], end[3];
    s->best.square = INFINITY;
    for (int i = 0; i < 3; ++i)
        offer_corner_of_piece(s, s->corner[i]);
    for (int bits = 0; bits < 8; ++bits) {
        if (!corner_of_core(p, bits, at))
            continue;
        offer_corner_of_core(s, at);
        for (int i = 0; i < 3; ++i)
            if (!(bits >> i & 1) && corner_of_core(p, bits | 1 << i, end))
                offer_edge_of_core(s, at, end);
    }
}

static void look_at(scene *s, const ground_piece *p, double t)
{
    s->low = -2.0 * s->probe->reach[2] - 1.0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            s->corner[i][k] = p->corner[i][k] - s->probe->centre[k] - t * s->probe->direction[k];
    if (s->is_sheet)
        set_top(s->corner, s->up);
}

// ---------------------------------------------------------------- the way

static bool core_meets_at_begin(const ground_piece *p, const ground_probe *probe)
{
    ground_probe still = *probe;
    ground_entry entry;
    memset(still.direction, 0, sizeof still.direction);
    still.t_max = 0.0f;
    return ground_piece_meet(p, &still, &entry);
}

static double size_of(const ground_piece *p, const ground_probe *probe)
{
    double size = probe->radius;
    for (int k = 0; k < 3; ++k)
        size += fabs(p->corner[0][k] - probe->centre[k]) + probe->reach[k];
    return size;
}

// As ground_piece_meet, of a probe with a radius, whose core is the box; touching within 2^-40 of
// the sizes. entry->t is the latest time that counts.
static bool meet_round(const ground_piece *p, const ground_probe *probe, ground_entry *entry)
{
    scene s = {.probe = probe, .is_sheet = p->is_sheet, .up = {0, 0, 1}};
    double t = 0.0, last = fmin(probe->t_max, entry->t), touching = TOUCHING * size_of(p, probe);
    if (core_meets_at_begin(p, probe)) {
        *entry = (ground_entry){0};
        return true;
    }
    for (int step = 0; step < STEPS; ++step) {
        look_at(&s, p, t);
        find_gap(&s);
        double length = sqrt(s.best.square), speed = 0.0;
        for (int k = 0; k < 3; ++k)
            speed -= s.best.way[k] * probe->direction[k] / length;
        if (length - probe->radius <= touching) {
            entry->t = t;
            memcpy(entry->normal, s.best.way, sizeof entry->normal);
            return true;
        }
        t += (length - probe->radius) / speed;
        if (!(speed > 0.0) || t > last)
            return false;
    }
    return false;
}

// ---------------------------------------------------------------- with a radius or without

bool ground_piece_improve(const ground_piece *p, const ground_probe *probe, ground_entry *best)
{
    ground_entry entry = *best;
    bool meets =
        probe->radius > 0.0 ? meet_round(p, probe, &entry) : ground_piece_meet(p, probe, &entry);
    if (!meets || entry.t >= best->t)
        return false;
    *best = entry;
    return true;
}
