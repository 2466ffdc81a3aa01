// SPDX-License-Identifier: MIT
// Distances of boxes against the sum of two radii.
//
// In double as on the devices (kernels/narrowphase/rounded.clh): two points of the cores that are
// near enough show that the boxes collide, a gap along the way between them that they do not.
#include "runtime/narrowphase/rounded.h"

#include "runtime/narrowphase/vector.h"

#include <math.h>

#define SLACK (NARROW_SLACK * 0x1p-53)
#define STEPS 64

static bool is_point(const duet_pose *core)
{
    const float *h = core->half_extents;
    return h[0] == 0 && h[1] == 0 && h[2] == 0;
}

// |t|_1, all extents and both radii.
static double size_of(const duet_rounded_box *a, const duet_rounded_box *b)
{
    double size = (double)a->radius + b->radius;
    for (int k = 0; k < 3; ++k)
        size += fabs((double)b->pose.centre[k] - a->pose.centre[k]) +
                ((double)a->pose.half_extents[k] + b->pose.half_extents[k]);
    return size;
}

// ---------------------------------------------------------------- along the world's axes

// A number, and whether any rounding was lost on the way to it.
typedef struct tally {
    double value;
    bool exact;
} tally;

static tally sum(tally a, tally b)
{
    double value = a.value + b.value, part = value - a.value;
    double lost = (a.value - (value - part)) + (b.value - part);
    return (tally){value, a.exact && b.exact && lost == 0};
}

// A square that is not 0 is far above the least double.
static tally square(tally a)
{
    double value = a.value * a.value;
    return (tally){value, a.exact && fma(a.value, a.value, -value) == 0};
}

static tally number(double value)
{
    return (tally){value, true};
}

static bool reach_upright(const duet_pose *core, double reach[3])
{
    reach[0] = reach[1] = reach[2] = 0;
    return is_point(core) || narrow_is_upright(core, reach);
}

static narrow_answer compare_upright(const duet_rounded_box *a, const duet_rounded_box *b,
                                     const double reach_a[3], const double reach_b[3])
{
    tally squares = number(0), reach = sum(number(a->radius), number(b->radius));
    for (int k = 0; k < 3; ++k) {
        tally way = sum(number(b->pose.centre[k]), number(-(double)a->pose.centre[k]));
        tally both = sum(number(reach_a[k]), number(reach_b[k]));
        way.value = fabs(way.value);
        both.value = -both.value;
        tally gap = sum(way, both);
        if (gap.value < 0)
            gap.value = 0;
        squares = sum(squares, square(gap));
    }
    tally limit = square(reach);
    double distance = sqrt(squares.value), slack = SLACK * size_of(a, b);
    if (squares.exact && limit.exact)
        return squares.value <= limit.value ? NARROW_COLLIDING : NARROW_SEPARATED;
    return distance > reach.value + slack   ? NARROW_SEPARATED
           : distance < reach.value - slack ? NARROW_COLLIDING
                                            : NARROW_UNDECIDED;
}

// ---------------------------------------------------------------- turned

// Two cores seen along a's edges.
typedef struct cores {
    double way[3];  // from a's centre to b's
    double c[3][3]; // cosines between edges of a and of b
    double a[3], b[3];
} cores;

// Points of both, along the edges of each.
typedef struct points {
    double x[3], y[3];
} points;

static double from_column(const cores *m, const double v[3], int j)
{
    return m->c[0][j] * v[0] + m->c[1][j] * v[1] + m->c[2][j] * v[2];
}

static double held(double at, double half)
{
    return fmin(fmax(at, -half), half);
}

static cores cores_of(const duet_pose *a, const duet_pose *b)
{
    cores m;
    double axis_a[3][3], axis_b[3][3], t[3];
    narrow_axes(axis_a, a->rotation);
    narrow_axes(axis_b, b->rotation);
    for (int i = 0; i < 3; ++i)
        t[i] = (double)b->centre[i] - a->centre[i];
    for (int i = 0; i < 3; ++i) {
        m.a[i] = a->half_extents[i];
        m.b[i] = b->half_extents[i];
        m.way[i] = dot(axis_a[i], t);
        for (int j = 0; j < 3; ++j)
            m.c[i][j] = dot(axis_a[i], axis_b[j]);
    }
    return m;
}

// The point of b nearest to a's, then that of a nearest to b's; gap is the way between.
static void draw_near(const cores *m, points *p, double gap[3])
{
    double back[3];
    for (int i = 0; i < 3; ++i)
        back[i] = p->x[i] - m->way[i];
    for (int j = 0; j < 3; ++j)
        p->y[j] = held(from_column(m, back, j), m->b[j]);
    for (int i = 0; i < 3; ++i) {
        double at = m->way[i] + dot(m->c[i], p->y);
        p->x[i] = held(at, m->a[i]);
        gap[i] = at - p->x[i];
    }
}

// The separation along the gap, times its length.
static double separation_along(const cores *m, const double gap[3])
{
    double separation = dot(gap, m->way);
    for (int k = 0; k < 3; ++k)
        separation -= m->a[k] * fabs(gap[k]) + m->b[k] * fabs(from_column(m, gap, k));
    return separation;
}

// How many times `part` can be added to `at` before it leaves the box.
static double times_within(double at, double part, double half)
{
    return part > 0 ? (half - at) / part : part < 0 ? (half + at) / -part : INFINITY;
}

// Goes on in the direction of the last step to where the gap is least, but not out of a box:
// what approaches slowly approaches along a line.
static void go_on(const cores *m, points *p, const points *last, const double gap[3])
{
    double dx[3], dy[3], change[3];
    for (int k = 0; k < 3; ++k) {
        dx[k] = p->x[k] - last->x[k];
        dy[k] = p->y[k] - last->y[k];
    }
    for (int i = 0; i < 3; ++i)
        change[i] = dot(m->c[i], dy) - dx[i];
    double squared = dot(change, change);
    double times = squared > 0 ? fmax(-dot(change, gap) / squared, 0) : 0;
    for (int k = 0; k < 3; ++k)
        times = fmin(times, fmin(times_within(p->x[k], dx[k], m->a[k]),
                                 times_within(p->y[k], dy[k], m->b[k])));
    for (int k = 0; k < 3; ++k)
        p->x[k] = held(p->x[k] + times * dx[k], m->a[k]);
}

static narrow_answer find_points(const duet_rounded_box *a, const duet_rounded_box *b)
{
    cores m = cores_of(&a->pose, &b->pose);
    double slack = SLACK * size_of(a, b), reach = (double)a->radius + b->radius;
    points p = {{0}, {0}}, last;
    for (int k = 0; k < 3; ++k)
        p.x[k] = held(m.way[k], m.a[k]);
    last = p;
    for (int step = 0; step < STEPS; ++step) {
        double gap[3];
        draw_near(&m, &p, gap);
        double length = sqrt(dot(gap, gap));
        if (length < reach - slack)
            return NARROW_COLLIDING;
        if (length > slack && separation_along(&m, gap) > (reach + slack) * length)
            return NARROW_SEPARATED;
        if (step > 0 && step % 2 == 0)
            go_on(&m, &p, &last, gap);
        last = p;
    }
    return NARROW_UNDECIDED;
}

// Returns how near the points come.
static double find_distance(const duet_pose *a, const duet_pose *b)
{
    cores m = cores_of(a, b);
    points p = {{0}, {0}}, last = p;
    double gap[3];
    for (int step = 0; step < STEPS; ++step) {
        draw_near(&m, &p, gap);
        if (step > 0 && step % 2 == 0)
            go_on(&m, &p, &last, gap);
        last = p;
    }
    draw_near(&m, &p, gap);
    return sqrt(dot(gap, gap));
}

double duet_rounded_boxes_separation(const duet_rounded_box *first, const duet_rounded_box *second,
                                     uint32_t dims)
{
    if (!first || !second || (dims != 2 && dims != 3))
        return NAN;
    duet_rounded_box a = rounded_flat(first, dims), b = rounded_flat(second, dims);
    double of_cores = narrow_widest_separation(&a.pose, &b.pose, narrow_here, dims);
    double between = of_cores > 0 ? find_distance(&a.pose, &b.pose) : of_cores;
    return between - ((double)a.radius + b.radius);
}

static bool turns_into_numbers(const duet_pose *core)
{
    double axis[3][3];
    double norm = narrow_axes(axis, core->rotation);
    return norm > 0 && norm < INFINITY;
}

narrow_answer rounded_double(const duet_rounded_box *first, const duet_rounded_box *second,
                             uint32_t dims)
{
    duet_rounded_box a = rounded_flat(first, dims), b = rounded_flat(second, dims);
    double reach_a[3], reach_b[3];
    if (reach_upright(&a.pose, reach_a) && reach_upright(&b.pose, reach_b))
        return compare_upright(&a, &b, reach_a, reach_b);
    narrow_answer of_cores = narrow_double(&a.pose, &b.pose, dims);
    bool sharp = a.radius == 0 && b.radius == 0;
    if (of_cores == NARROW_COLLIDING || sharp)
        return of_cores;
    bool sound = turns_into_numbers(&a.pose) && turns_into_numbers(&b.pose);
    return sound ? find_points(&a, &b) : NARROW_UNDECIDED;
}

// ---------------------------------------------------------------- either way

bool rounded_decide(const duet_rounded_box *a, const duet_rounded_box *b, uint32_t dims)
{
    narrow_answer answer = rounded_double(a, b, dims);
    return answer == NARROW_UNDECIDED ? rounded_exact(a, b, dims) : answer == NARROW_COLLIDING;
}

bool duet_rounded_boxes_collide(const duet_rounded_box *a, const duet_rounded_box *b, uint32_t dims)
{
    return a && b && (dims == 2 || dims == 3) && rounded_is_sound(a, dims) &&
           rounded_is_sound(b, dims) && rounded_decide(a, b, dims);
}
