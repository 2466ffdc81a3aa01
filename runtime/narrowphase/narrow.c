// SPDX-License-Identifier: MIT
// Separating axes in double.
//
// For each axis L the separation |t.L| - (ra + rb) comes with an error of at most
// `slack`; a separation above it separates, and separations all below minus it collide.
//
// Nearly parallel edges make a cross axis of nearly no length, whose separation says
// nothing. Such an axis is not needed where the other axes overlap by more
// than the tilt between the edges can take away (docs/accuracy.md, "Nearly
// parallel edges").
#include "runtime/narrowphase/narrow.h"

#include "base/compare.h"
#include "runtime/narrowphase/vector.h"

#include <math.h>

#define SLACK (NARROW_SLACK * 0x1p-53)
#define PARALLEL 0.5 // edges with a smaller tilt count as nearly parallel

static const int next[3] = {1, 2, 0};
static const int last[3] = {2, 0, 1};

typedef struct box {
    double half_extents[3];
    double axis[3][3]; // axis[i]: the direction of edge i
    double norm;       // |q|^2
} box;

static box box_of_pose(const duet_pose *pose)
{
    box b = {.half_extents = {pose->half_extents[0], pose->half_extents[1], pose->half_extents[2]}};
    b.norm = narrow_axes(b.axis, pose->rotation);
    return b;
}

// The separations of the axes tried so far.
typedef struct separations {
    double slack;    // bounds the error of each separation
    double greatest; // of all axes
    double needed;   // greatest of the axes that are not between nearly parallel edges
    double tilt;     // greatest between nearly parallel edges whose axis decides nothing
} separations;

static void add_face(separations *g, double separation)
{
    g->greatest = greater(g->greatest, separation);
    g->needed = greater(g->needed, separation);
}

static void add_edges(separations *g, double separation, double tilt)
{
    g->greatest = greater(g->greatest, separation);
    if (tilt >= PARALLEL)
        g->needed = greater(g->needed, separation);
    else if (separation >= -g->slack)
        g->tilt = greater(g->tilt, tilt);
}

// Two boxes as the axes see them: everything in a's and b's own directions.
typedef struct view {
    double a[3], b[3];   // half extents
    double ta[3], tb[3]; // from a's centre to b's, along a's axes and along b's
    double c[3][3];      // cosines between a's axis i and b's axis j
} view;

static view view_of(const box *a, const box *b, const double t[3])
{
    view v;
    for (int i = 0; i < 3; ++i) {
        v.a[i] = a->half_extents[i];
        v.b[i] = b->half_extents[i];
        v.ta[i] = dot(a->axis[i], t);
        v.tb[i] = dot(b->axis[i], t);
        for (int j = 0; j < 3; ++j)
            v.c[i][j] = dot(a->axis[i], b->axis[j]);
    }
    return v;
}

static void add_faces(separations *g, const view *v, int dims)
{
    const double(*c)[3] = v->c;
    for (int i = 0; i < dims; ++i) {
        double rb = v->b[0] * fabs(c[i][0]) + v->b[1] * fabs(c[i][1]) + v->b[2] * fabs(c[i][2]);
        double ra = v->a[0] * fabs(c[0][i]) + v->a[1] * fabs(c[1][i]) + v->a[2] * fabs(c[2][i]);
        add_face(g, fabs(v->ta[i]) - (v->a[i] + rb));
        add_face(g, fabs(v->tb[i]) - (v->b[i] + ra));
    }
}

// Along the product of edge i of a and edge j of b, as long as the sine between.
static double edge_separation(const view *v, int i, int j)
{
    const double(*c)[3] = v->c;
    int i1 = next[i], i2 = last[i], j1 = next[j], j2 = last[j];
    double ra = v->a[i1] * fabs(c[i2][j]) + v->a[i2] * fabs(c[i1][j]);
    double rb = v->b[j1] * fabs(c[i][j2]) + v->b[j2] * fabs(c[i][j1]);
    double distance = fabs(v->ta[i2] * c[i1][j] - v->ta[i1] * c[i2][j]);
    return distance - (ra + rb);
}

static void add_cross_axes(separations *g, const view *v)
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double tilt = fabs(v->c[i][next[j]]) + fabs(v->c[i][last[j]]);
            add_edges(g, edge_separation(v, i, j), tilt);
        }
}

static double largest(const double v[3])
{
    return greater(v[0], greater(v[1], v[2]));
}

static narrow_answer answer_of(const separations *g, const view *v)
{
    if (g->greatest > g->slack)
        return NARROW_SEPARATED;
    double lost = lesser(largest(v->a), largest(v->b)) * g->tilt;
    return g->needed + lost < -g->slack ? NARROW_COLLIDING : NARROW_UNDECIDED;
}

// Whether a rotation turns axes into axes: then those of the quaternion's parts
// that are not 0 are of one size, and there are one, two or four of them.
static bool keeps_axes(const duet_pose *pose)
{
    const float *q = pose->rotation;
    float size = fmaxf(fmaxf(fabsf(q[0]), fabsf(q[1])), fmaxf(fabsf(q[2]), fabsf(q[3])));
    int n = 0;
    for (int i = 0; i < 4; ++i) {
        if (q[i] != 0 && fabsf(q[i]) != size)
            return false;
        n += q[i] != 0;
    }
    return n == 1 || n == 2 || n == 4;
}

// The extent along axis k of the world of a box whose rotation keeps axes.
static double half_along(const box *b, int k)
{
    int edge = 0;
    while (edge < 2 && fabs(b->axis[edge][k]) < 0.5)
        ++edge;
    return b->half_extents[edge];
}

bool narrow_is_upright(const duet_pose *pose, double reach[3])
{
    if (!keeps_axes(pose))
        return false;
    box b = box_of_pose(pose);
    for (int k = 0; k < 3; ++k)
        reach[k] = half_along(&b, k);
    return true;
}

// A sum of two doubles as its rounding and what that left over.
typedef struct sum {
    double high, low;
} sum;

static sum exact_sum(double x, double y)
{
    double high = x + y;
    double part = high - x;
    return (sum){high, (x - (high - part)) + (y - part)};
}

static double sum_of_sizes(const double t[3], const double a[3], const double b[3])
{
    double size = 0;
    for (int i = 0; i < 3; ++i)
        size += fabs(t[i]) + fabs(a[i]) + fabs(b[i]);
    return size;
}

// The state before any axis is tried.
typedef struct approach {
    box a, b;
    double t[3];
    double size; // |t|_1 and all extents
} approach;

static approach approach_of(const duet_pose *pose_a, const duet_pose *pose_b, const double shift[3],
                            uint32_t dims)
{
    approach p = {.a = box_of_pose(pose_a), .b = box_of_pose(pose_b)};
    for (uint32_t i = 0; i < dims; ++i)
        p.t[i] = ((double)pose_b->centre[i] - pose_a->centre[i]) + shift[i];
    p.size = sum_of_sizes(p.t, p.a.half_extents, p.b.half_extents);
    return p;
}

static bool is_finite(const approach *p)
{
    return p->size < INFINITY && p->a.norm > 0 && p->a.norm < INFINITY && p->b.norm > 0 &&
           p->b.norm < INFINITY;
}

// The way between the centres along an axis; a shift comes with a difference of
// theirs that is exact.
static sum exact_way(float from, float to, double shift)
{
    return shift == 0 ? exact_sum(to, -(double)from) : exact_sum((double)to - from, shift);
}

// Boxes along the world's axes need two sums of two floats an axis, which high
// and low hold exactly, and rounding keeps order: so comparing highs, then lows,
// is exact.
static narrow_answer compare_upright(const duet_pose *a, const duet_pose *b, const double shift[3],
                                     const approach *p, int dims)
{
    for (int i = 0; i < dims; ++i) {
        sum t = exact_way(a->centre[i], b->centre[i], shift[i]);
        sum reach = exact_sum(half_along(&p->a, i), half_along(&p->b, i));
        if (t.high < 0)
            t = (sum){-t.high, -t.low};
        if (t.high > reach.high || (t.high == reach.high && t.low > reach.low))
            return NARROW_SEPARATED;
    }
    return NARROW_COLLIDING;
}

static narrow_answer test_axes(const approach *p, int dims)
{
    view v = view_of(&p->a, &p->b, p->t);
    separations g = {SLACK * p->size, -INFINITY, -INFINITY, 0};
    add_faces(&g, &v, dims);
    if (dims == 3 && g.greatest <= g.slack)
        add_cross_axes(&g, &v);
    return answer_of(&g, &v);
}

static narrow_answer double_apart(const duet_pose *pose_a, const duet_pose *pose_b,
                                  const double shift[3], uint32_t dims)
{
    duet_pose a = narrow_flat(pose_a, dims), b = narrow_flat(pose_b, dims);
    approach p = approach_of(&a, &b, shift, dims);
    if (!is_finite(&p))
        return NARROW_UNDECIDED;
    if (keeps_axes(&a) && keeps_axes(&b))
        return compare_upright(&a, &b, shift, &p, (int)dims);
    return test_axes(&p, (int)dims);
}

narrow_answer narrow_double(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    return double_apart(a, b, narrow_here, dims);
}

double narrow_separation_apart(const duet_pose *pose_a, const duet_pose *pose_b,
                               const double shift[3], uint32_t dims)
{
    duet_pose a = narrow_flat(pose_a, dims), b = narrow_flat(pose_b, dims);
    approach p = approach_of(&a, &b, shift, dims);
    view v = view_of(&p.a, &p.b, p.t);
    separations g = {0, -INFINITY, -INFINITY, 0};
    add_faces(&g, &v, (int)dims);
    if (dims == 3)
        add_cross_axes(&g, &v);
    return g.greatest;
}

// Edges nearer to parallel than this show in double no direction of their own,
// and what the faces show is as good.
#define LEAST_SINE 1e-7

double duet_poses_separation(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    if (!a || !b || (dims != 2 && dims != 3))
        return NAN;
    return narrow_widest_separation(a, b, narrow_here, dims);
}

double narrow_widest_separation(const duet_pose *pose_a, const duet_pose *pose_b,
                                const double shift[3], uint32_t dims)
{
    duet_pose a = narrow_flat(pose_a, dims), b = narrow_flat(pose_b, dims);
    approach p = approach_of(&a, &b, shift, dims);
    view v = view_of(&p.a, &p.b, p.t);
    separations g = {0, -INFINITY, -INFINITY, 0};
    add_faces(&g, &v, (int)dims);
    for (int i = 0; dims == 3 && i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double sine = hypot(v.c[next[i]][j], v.c[last[i]][j]);
            if (sine > LEAST_SINE)
                g.greatest = greater(g.greatest, edge_separation(&v, i, j) / sine);
        }
    return g.greatest;
}

bool narrow_decide_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                         uint32_t dims)
{
    narrow_answer answer = double_apart(a, b, shift, dims);
    if (answer == NARROW_UNDECIDED)
        return narrow_exact_apart(a, b, shift, dims);
    return answer == NARROW_COLLIDING;
}

bool narrow_decide(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    return narrow_decide_apart(a, b, narrow_here, dims);
}

bool narrow_bounds(const duet_bounds *a, const duet_bounds *b, uint32_t dims)
{
    for (uint32_t i = 0; i < dims; ++i)
        if (a->upper[i] < b->lower[i] || b->upper[i] < a->lower[i])
            return false;
    return true;
}

bool duet_poses_collide(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    return a && b && (dims == 2 || dims == 3) && narrow_is_box(a, dims) && narrow_is_box(b, dims) &&
           narrow_decide(a, b, dims);
}
