// SPDX-License-Identifier: MIT
// As kernels/queries/sweep.clh with radii, with the unit of rounding of a double; then by integers.
//
// The distance of the cores is convex along the way. A gap between them has a direction, and along
// that they come nearer at a constant speed: no sooner than that they touch. So from the begin each
// such gap leads to a later t, and never beyond the first at which the two touch.
#include "runtime/queries/rounded_sweep.h"

#include "runtime/narrowphase/exact.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/narrowphase/vector.h"
#include "runtime/queries/sweep.h"

#include <math.h>

static duet_rounded_sweep flat_sweep(const duet_rounded_sweep *sweep, uint32_t dims)
{
    duet_rounded_sweep flat = *sweep;
    flat.box.pose = narrow_flat(&sweep->box.pose, dims);
    if (dims == 2)
        flat.direction[2] = 0;
    return flat;
}

static duet_sweep sweep_of_core(const duet_rounded_sweep *sweep)
{
    return (duet_sweep){sweep->box.pose,
                        {sweep->direction[0], sweep->direction[1], sweep->direction[2]},
                        sweep->t_max};
}

// ---------------------------------------------------------------- double

#define SLACK (320 * 0x1p-53) // relative to the two boxes' size, as in sweep.clh
#define BESIDE 1e-6           // cosine: an edge that faces neither way
#define STEPS 200

typedef enum met { MISSED, MET, OPEN } met;

typedef struct core {
    double axis[3][3], half[3];
} core;

// a moves.
typedef struct chase {
    core a, b;
    double way[3], go[3]; // from a's centre to b's at the begin, and what a's moves by
    double size, doubt, reach, end;
} chase;

// From a to b, as near as their cores come at some t, and what is known by it.
typedef struct gap {
    double way[3], length;
    double apart; // along it both reach no further: the cores are at least so far apart
    double speed; // with which they come nearer along it
} gap;

static core core_of(const duet_pose *pose)
{
    core c;
    narrow_axes(c.axis, pose->rotation);
    for (int k = 0; k < 3; ++k)
        c.half[k] = pose->half_extents[k];
    return c;
}

static double reach_along(const core *c, const double way[3])
{
    double reach = 0;
    for (int k = 0; k < 3; ++k)
        reach += c->half[k] * fabs(dot(c->axis[k], way));
    return reach;
}

// No two that meet do so later than at `end`: by then the centres are further apart than both
// reach.
static chase chase_of(const duet_rounded_sweep *sweep, const duet_rounded_box *box)
{
    chase c = {.a = core_of(&sweep->box.pose), .b = core_of(&box->pose)};
    double length = 0;
    c.reach = c.size = (double)sweep->box.radius + box->radius;
    for (int k = 0; k < 3; ++k) {
        c.way[k] = (double)box->pose.centre[k] - sweep->box.pose.centre[k];
        c.go[k] = sweep->direction[k];
        c.size += fabs(c.way[k]) + c.a.half[k] + c.b.half[k];
        length += fabs(c.go[k]);
    }
    c.doubt = SLACK * c.size;
    c.end = length > 0 ? fmin(sweep->t_max, 2 * sqrt(3) * c.size / length) : 0;
    return c;
}

static void offer(gap *best, const double on_a[3], const double on_b[3])
{
    double way[3], square;
    for (int k = 0; k < 3; ++k)
        way[k] = on_b[k] - on_a[k];
    square = dot(way, way);
    if (!(square < best->length))
        return;
    best->length = square;
    for (int k = 0; k < 3; ++k)
        best->way[k] = way[k];
}

// The point nearest to `to`, both from the box's centre.
static void point_of(const core *c, const double to[3], double point[3])
{
    point[0] = point[1] = point[2] = 0;
    for (int i = 0; i < 3; ++i) {
        double at = fmin(fmax(dot(to, c->axis[i]), -c->half[i]), c->half[i]);
        for (int k = 0; k < 3; ++k)
            point[k] += at * c->axis[i][k];
    }
}

// Corner `bits` of eight, `but` edge i; false where it is another one's place.
static bool corner_of(const core *c, int bits, int but, double corner[3])
{
    corner[0] = corner[1] = corner[2] = 0;
    for (int i = 0; i < 3; ++i) {
        bool upper = bits >> i & 1;
        if (upper && (i == but || c->half[i] == 0))
            return false;
        for (int k = 0; i != but && k < 3; ++k)
            corner[k] += (upper ? c->half[i] : -c->half[i]) * c->axis[i][k];
    }
    return true;
}

// at: from a's centre to b's.
static void offer_corners(gap *best, const chase *c, const double at[3])
{
    double corner[3], other[3], to[3];
    for (int bits = 0; bits < 8; ++bits) {
        if (corner_of(&c->a, bits, -1, corner)) {
            for (int k = 0; k < 3; ++k)
                to[k] = corner[k] - at[k];
            point_of(&c->b, to, other);
            for (int k = 0; k < 3; ++k)
                other[k] += at[k];
            offer(best, corner, other);
        }
        if (corner_of(&c->b, bits, -1, corner)) {
            for (int k = 0; k < 3; ++k)
                corner[k] += at[k];
            point_of(&c->a, corner, other);
            offer(best, other, corner);
        }
    }
}

// Whether an edge along axis `but` on the sides that bits name faces a direction.
static bool is_facing(const core *c, int bits, int but, const double way[3], double length)
{
    for (int i = 0; i < 3; ++i) {
        double along = dot(c->axis[i], way) * (bits >> i & 1 ? 1 : -1);
        if (i != but && c->half[i] > 0 && along < -BESIDE * length)
            return false;
    }
    return true;
}

static void offer_crossing(gap *best, const chase *c, int i, int j, const double on_a[3],
                           const double on_b[3], const double across[3], double square)
{
    double between[3], moment[3], from[3], to[3];
    const double *edge_a = c->a.axis[i], *edge_b = c->b.axis[j];
    for (int k = 0; k < 3; ++k)
        between[k] = on_b[k] - on_a[k];
    cross(moment, between, edge_b);
    double s = fmin(fmax(dot(moment, across) / square, -c->a.half[i]), c->a.half[i]);
    cross(moment, between, edge_a);
    double t = fmin(fmax(dot(moment, across) / square, -c->b.half[j]), c->b.half[j]);
    for (int k = 0; k < 3; ++k) {
        from[k] = on_a[k] + s * edge_a[k];
        to[k] = on_b[k] + t * edge_b[k];
    }
    offer(best, from, to);
}

static void offer_crossings(gap *best, const chase *c, const double at[3])
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double across[3], out[3], in[3], on_a[3], on_b[3];
            cross(across, c->a.axis[i], c->b.axis[j]);
            double square = dot(across, across), length = sqrt(square);
            if (c->a.half[i] == 0 || c->b.half[j] == 0 || square < 1e-24)
                continue;
            for (int k = 0; k < 3; ++k) {
                out[k] = dot(across, at) < 0 ? -across[k] : across[k];
                in[k] = -out[k];
            }
            for (int bits = 0; bits < 64; ++bits) {
                if (!is_facing(&c->a, bits & 7, i, out, length) ||
                    !is_facing(&c->b, bits >> 3, j, in, length) ||
                    !corner_of(&c->a, bits & 7, i, on_a) || !corner_of(&c->b, bits >> 3, j, on_b))
                    continue;
                for (int k = 0; k < 3; ++k)
                    on_b[k] += at[k];
                offer_crossing(best, c, i, j, on_a, on_b, across, square);
            }
        }
}

// Cores that are apart are nearest at a corner of one, or where two edges cross.
static gap gap_at(const chase *c, double t)
{
    gap g = {.length = INFINITY};
    double at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = c->way[k] - t * c->go[k];
    offer_corners(&g, c, at);
    offer_crossings(&g, c, at);
    g.length = sqrt(g.length);
    if (g.length > 0) {
        g.apart =
            (dot(g.way, at) - reach_along(&c->a, g.way) - reach_along(&c->b, g.way)) / g.length;
        g.speed = dot(g.way, c->go) / g.length;
    }
    return g;
}

// Goes on to where the cores are `target` apart. MISSED where they surely never come within
// both radii, MET where they are there, OPEN where they may not come there.
static met approach(const chase *c, double target, double *t, gap *g)
{
    double far = c->reach + c->doubt;
    for (int step = 0; step < STEPS; ++step) {
        *g = gap_at(c, *t);
        if (g->apart <= target)
            return MET;
        if (g->apart > far && g->apart - g->speed * (c->end - *t) > far)
            return MISSED;
        double next = fmin(*t + (g->apart - target) / g->speed, c->end);
        if (!(g->speed > 0 && next > *t))
            return OPEN;
        *t = next;
    }
    return OPEN;
}

// Computes it for cores that do not meet.
static met meet_in_double(const chase *c)
{
    double t = 0, near = c->reach - c->doubt;
    gap g;
    if (!(c->size > 0x1p-140) || !isfinite(c->size)) // underflows could count
        return OPEN;
    met found = approach(c, c->reach, &t, &g);
    if (found == MISSED || near <= c->doubt)
        return found == MISSED ? MISSED : OPEN;
    if (g.length >= near)
        approach(c, near - c->doubt, &t, &g);
    return g.length < near ? MET : OPEN;
}

// Trims the report: no t above t_max, and no normal where t is 0.
static float report(double t, const gap *g, float t_max, float normal[3])
{
    float rounded = (float)t < t_max ? (float)t : t_max;
    for (int k = 0; k < 3; ++k)
        normal[k] = rounded > 0 && g->length > 0 ? (float)(-g->way[k] / g->length) + 0.0f : 0.0f;
    return rounded;
}

float rounded_sweep_enter(const duet_rounded_sweep *sweep, const duet_rounded_box *box,
                          uint32_t dims, float normal[3])
{
    duet_rounded_sweep flat = flat_sweep(sweep, dims);
    duet_rounded_box other = {narrow_flat(&box->pose, dims), box->radius};
    duet_sweep alone = sweep_of_core(&flat);
    chase c = chase_of(&flat, &other);
    double t = 0;
    // Radii that are lost beside the boxes change no t, but leave a gap without direction.
    double seen = 0x1p-26 * c.size;
    if (c.reach <= seen && sweep_meets(&alone, &other.pose, dims))
        return sweep_enter(&alone, &other.pose, dims, normal);
    gap g = gap_at(&c, 0), last;
    if (!(g.apart <= c.reach + c.doubt && rounded_decide(&flat.box, &other, dims))) {
        approach(&c, fmax(c.reach, seen), &t, &g);
        if (c.reach < seen)
            approach(&c, c.reach, &t, &last);
    }
    return report(t, &g, sweep->t_max, normal);
}

// ---------------------------------------------------------------- integers

// The offsets that both boxes, without their radii, can be apart by are a body with six edges in
// each corner, and the way is a segment or a half-line; if they do not meet, they are nearest where
// an end of the way is nearest to a corner, an edge or a face, or the way to a corner or an edge.
// Each of these that is near enough is proof, so that only sides need be tried: an edge is from -1
// to 1 times its half.
enum { EDGES = 6, WAY = EDGES };

typedef struct numbers {
    mpz_t q[4], norm_a, norm_b, norms;
    mpz_t edges[EDGES + 1][3];  // the last is the way
    mpz_t begin[3], at[3];      // from b's centre to a's, and less some sides
    mpz_t limit;                // both radii, squared
    mpz_t across[3], moment[3]; // cross products: two edges; `at` and one
    mpz_t square, along, beside, term;
} numbers;

static void set_edges(numbers *n, mpz_t edges[3][3], const duet_pose *pose, int power,
                      const mpz_t norm_other)
{
    for (int i = 0; i < 3; ++i) {
        exact_integer(n->term, pose->half_extents[i], power);
        mpz_mul(n->term, n->term, norm_other);
        for (int k = 0; k < 3; ++k)
            mpz_mul(edges[i][k], edges[i][k], n->term);
    }
}

// All lengths times both norms.
static void set_numbers(numbers *n, const duet_rounded_sweep *sweep, const duet_rounded_box *box)
{
    const duet_pose *a = &sweep->box.pose, *b = &box->pose;
    const float radii[2] = {sweep->box.radius, box->radius};
    int power = exact_least_power(radii, 2, 0);
    power = exact_least_power_of_boxes(a, b, narrow_here, power);
    power = exact_step(n->edges[WAY], sweep->direction, sweep->t_max, power);
    exact_axes(n->edges, n->norm_a, n->q, a->rotation);
    exact_axes(n->edges + 3, n->norm_b, n->q, b->rotation);
    mpz_mul(n->norms, n->norm_a, n->norm_b);
    set_edges(n, n->edges, a, power, n->norm_b);
    set_edges(n, n->edges + 3, b, power, n->norm_a);
    exact_integer(n->limit, radii[0], power);
    exact_integer(n->term, radii[1], power);
    mpz_add(n->limit, n->limit, n->term);
    mpz_mul(n->limit, n->limit, n->norms);
    mpz_mul(n->limit, n->limit, n->limit);
    exact_way(n->begin, b->centre, a->centre, narrow_here, power, n->term);
    for (int k = 0; k < 3; ++k) {
        mpz_mul(n->edges[WAY][k], n->edges[WAY][k], n->norms);
        mpz_mul(n->begin[k], n->begin[k], n->norms);
    }
}

static bool has_length(mpz_t edge[3])
{
    return mpz_sgn(edge[0]) != 0 || mpz_sgn(edge[1]) != 0 || mpz_sgn(edge[2]) != 0;
}

// Whether n->along / n->square is a place on the edge. The way begins at 0 and goes the other way.
static bool is_on(const numbers *n, int edge, bool ends)
{
    if (edge != WAY)
        return mpz_cmpabs(n->along, n->square) <= 0;
    return mpz_sgn(n->along) <= 0 && (!ends || mpz_cmpabs(n->along, n->square) <= 0);
}

static bool is_corner_near(numbers *n)
{
    exact_dot(n->square, n->at, n->at);
    return mpz_cmp(n->square, n->limit) <= 0;
}

static bool is_edge_near(numbers *n, int edge, bool ends)
{
    exact_dot(n->along, n->at, n->edges[edge]);
    exact_dot(n->square, n->edges[edge], n->edges[edge]);
    if (!is_on(n, edge, ends))
        return false;
    exact_dot(n->beside, n->at, n->at);
    mpz_mul(n->beside, n->beside, n->square);
    mpz_submul(n->beside, n->along, n->along);
    mpz_mul(n->term, n->limit, n->square);
    return mpz_cmp(n->beside, n->term) <= 0;
}

// The face that two edges make, of which n->across and n->square are known.
static bool is_face_near(numbers *n, int u, int v, bool ends)
{
    exact_dot(n->beside, n->at, n->across);
    mpz_mul(n->beside, n->beside, n->beside);
    mpz_mul(n->term, n->limit, n->square);
    if (mpz_cmp(n->beside, n->term) > 0)
        return false;
    exact_cross(n->moment, n->at, n->edges[v]);
    exact_dot(n->along, n->moment, n->across);
    if (!is_on(n, u, ends))
        return false;
    exact_cross(n->moment, n->edges[u], n->at);
    exact_dot(n->along, n->moment, n->across);
    return is_on(n, v, ends);
}

// n->at: the begin, or the end of the way, less the edges that are not `free`, each to a side.
// False where a side is another one's.
static bool set_place(numbers *n, unsigned sides, unsigned free, bool at_end)
{
    for (int k = 0; k < 3; ++k) {
        mpz_set(n->at[k], n->begin[k]);
        if (at_end)
            mpz_add(n->at[k], n->at[k], n->edges[WAY][k]);
    }
    for (int i = 0; i < EDGES; ++i) {
        bool upper = sides >> i & 1;
        if (upper && ((free >> i & 1) || !has_length(n->edges[i])))
            return false;
        for (int k = 0; !(free >> i & 1) && k < 3; ++k)
            (upper ? mpz_sub : mpz_add)(n->at[k], n->at[k], n->edges[i][k]);
    }
    return true;
}

// Calls for every place that edges u and v leave; -1: none. Without the way, of both ends.
static bool any_is_near(numbers *n, int u, int v, bool ends)
{
    unsigned free = (u >= 0 ? 1u << u : 0) | (v >= 0 ? 1u << v : 0);
    bool moves = u == WAY || v == WAY;
    for (unsigned end = 0; end <= (ends && !moves); ++end)
        for (unsigned sides = 0; sides < 1 << EDGES; ++sides)
            if (set_place(n, sides, free, end) && (v >= 0   ? is_face_near(n, u, v, ends)
                                                   : u >= 0 ? is_edge_near(n, u, ends)
                                                            : is_corner_near(n)))
                return true;
    return false;
}

static bool any_corner_edge_or_face_is_near(numbers *n, bool ends)
{
    if (any_is_near(n, -1, -1, ends))
        return true;
    for (int u = 0; u <= WAY; ++u) {
        if (has_length(n->edges[u]) && any_is_near(n, u, -1, ends))
            return true;
        for (int v = u + 1; v <= WAY; ++v) {
            exact_cross(n->across, n->edges[u], n->edges[v]);
            exact_dot(n->square, n->across, n->across);
            if (mpz_sgn(n->square) > 0 && any_is_near(n, u, v, ends))
                return true;
        }
    }
    return false;
}

bool rounded_sweep_meets_exactly(const duet_rounded_sweep *sweep, const duet_rounded_box *box,
                                 uint32_t dims)
{
    duet_rounded_sweep flat = flat_sweep(sweep, dims);
    duet_rounded_box other = {narrow_flat(&box->pose, dims), box->radius};
    duet_sweep alone = sweep_of_core(&flat);
    if (sweep_meets_exactly(&alone, &other.pose, dims))
        return true;
    if (flat.box.radius == 0 && other.radius == 0)
        return false;
    numbers n;
    exact_open(&n, sizeof n);
    set_numbers(&n, &flat, &other);
    bool near = any_corner_edge_or_face_is_near(&n, isfinite(sweep->t_max));
    exact_close(&n, sizeof n);
    return near;
}

bool rounded_sweep_meets(const duet_rounded_sweep *sweep, const duet_rounded_box *box,
                         uint32_t dims)
{
    duet_rounded_sweep flat = flat_sweep(sweep, dims);
    duet_rounded_box other = {narrow_flat(&box->pose, dims), box->radius};
    duet_sweep alone = sweep_of_core(&flat);
    if (sweep_meets(&alone, &other.pose, dims))
        return true;
    chase c = chase_of(&flat, &other);
    if (c.reach == 0)
        return false;
    met found = meet_in_double(&c);
    return found == OPEN ? rounded_sweep_meets_exactly(sweep, box, dims) : found == MET;
}
