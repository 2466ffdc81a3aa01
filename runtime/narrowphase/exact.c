// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/exact.h"

#include "runtime/narrowphase/rounded.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>

void exact_open(void *numbers, size_t bytes)
{
    for (mpz_t *at = numbers, *end = at + bytes / sizeof *at; at < end; ++at)
        mpz_init(*at);
}

void exact_close(void *numbers, size_t bytes)
{
    for (mpz_t *at = numbers, *end = at + bytes / sizeof *at; at < end; ++at)
        mpz_clear(*at);
}

static int lesser_power(double value, int bits, int so_far)
{
    int power;
    frexp(value, &power);
    return value != 0 && power - bits < so_far ? power - bits : so_far;
}

int exact_least_power(const float *values, int n, int so_far)
{
    for (int i = 0; i < n; ++i)
        so_far = lesser_power(values[i], 24, so_far);
    return so_far;
}

int exact_least_power_of_boxes(const duet_pose *a, const duet_pose *b, const double shift[3],
                               int so_far)
{
    for (int k = 0; k < 3; ++k)
        so_far = lesser_power(shift[k], 53, so_far);
    so_far = exact_least_power(a->centre, 3, so_far);
    so_far = exact_least_power(a->half_extents, 3, so_far);
    so_far = exact_least_power(b->centre, 3, so_far);
    return exact_least_power(b->half_extents, 3, so_far);
}

void exact_integer(mpz_t out, double value, int power)
{
    mpz_set_d(out, ldexp(value, -power));
}

void exact_way(mpz_t out[3], const float from[3], const float to[3], const double shift[3],
               int power, mpz_t term)
{
    for (int k = 0; k < 3; ++k) {
        exact_integer(out[k], to[k], power);
        exact_integer(term, from[k], power);
        mpz_sub(out[k], out[k], term);
        exact_integer(term, shift[k], power);
        mpz_add(out[k], out[k], term);
    }
}

// out = 2 (x y + sign z w)
static void set_twice(mpz_t out, const mpz_t x, const mpz_t y, int sign, const mpz_t z,
                      const mpz_t w)
{
    mpz_mul(out, x, y);
    (sign > 0 ? mpz_addmul : mpz_submul)(out, z, w);
    mpz_mul_2exp(out, out, 1);
}

// out = w w + plus plus - minus minus - less less
static void set_diagonal(mpz_t out, const mpz_t w, const mpz_t plus, const mpz_t minus,
                         const mpz_t less)
{
    mpz_mul(out, w, w);
    mpz_addmul(out, plus, plus);
    mpz_submul(out, minus, minus);
    mpz_submul(out, less, less);
}

void exact_axes(mpz_t axis[3][3], mpz_t norm, mpz_t q[4], const float rotation[4])
{
    int power = exact_least_power(rotation, 4, INT_MAX);
    mpz_set_ui(norm, 0);
    for (int i = 0; i < 4; ++i) {
        exact_integer(q[i], rotation[i], power);
        mpz_addmul(norm, q[i], q[i]);
    }
    set_diagonal(axis[0][0], q[3], q[0], q[1], q[2]);
    set_twice(axis[0][1], q[0], q[1], 1, q[3], q[2]);
    set_twice(axis[0][2], q[0], q[2], -1, q[3], q[1]);
    set_twice(axis[1][0], q[0], q[1], -1, q[3], q[2]);
    set_diagonal(axis[1][1], q[3], q[1], q[0], q[2]);
    set_twice(axis[1][2], q[1], q[2], 1, q[3], q[0]);
    set_twice(axis[2][0], q[0], q[2], 1, q[3], q[1]);
    set_twice(axis[2][1], q[1], q[2], -1, q[3], q[0]);
    set_diagonal(axis[2][2], q[3], q[2], q[0], q[1]);
}

void exact_dot(mpz_t out, mpz_t u[3], mpz_t v[3])
{
    mpz_mul(out, u[0], v[0]);
    mpz_addmul(out, u[1], v[1]);
    mpz_addmul(out, u[2], v[2]);
}

void exact_cross(mpz_t *out, mpz_t *u, mpz_t *v)
{
    for (int k = 0; k < 3; ++k) {
        mpz_mul(out[k], u[(k + 1) % 3], v[(k + 2) % 3]);
        mpz_submul(out[k], u[(k + 2) % 3], v[(k + 1) % 3]);
    }
}

int exact_step(mpz_t out[3], const float direction[3], float t_max, int power)
{
    bool ends = isfinite(t_max);
    int t_power = exact_least_power(&t_max, ends, 0);
    int v_power = exact_least_power(direction, 3, 0);
    if (ends && t_power + v_power < power)
        power = t_power + v_power;
    mpz_t last;
    mpz_init(last);
    exact_integer(last, ends ? t_max : 1, t_power);
    for (int k = 0; k < 3; ++k) {
        exact_integer(out[k], direction[k], v_power);
        if (!ends)
            continue;
        mpz_mul(out[k], out[k], last);
        mpz_mul_2exp(out[k], out[k], (mp_bitcnt_t)(t_power + v_power - power));
    }
    mpz_clear(last);
    return power;
}

// ---------------------------------------------------------------- two boxes

// Separating axes in exact integers.
//
// A float is an integer times a power of two. Centres and extents share one
// power and each quaternion has its own, which its rotation M(q)/|q|^2 does
// not feel. Multiplied through by |qa|^2 and |qb|^2, every axis compares two
// integers; an axis of no length compares 0 with 0 and separates nothing.

typedef struct numbers {
    mpz_t half_a[3], half_b[3], t[3];
    mpz_t q[4];
    mpz_t norm_a, norm_b, norms; // |qa|^2, |qb|^2, their product
    mpz_t axis_a[3][3];          // [i]: the direction of edge i, of length norm_a
    mpz_t axis_b[3][3];          //      of length norm_b
    mpz_t c[3][3];               // axis_a[i] . axis_b[j]
    mpz_t by_a[3][3];            // |c[i][j]|
    mpz_t by_b[3][3];            // |c[j][i]|
    mpz_t t_a[3], t_b[3];        // t . axis_a[i], t . axis_b[j]
    mpz_t distance, reach, term;
} numbers;

static void set_lengths(numbers *n, const duet_pose *a, const duet_pose *b, const double shift[3])
{
    int power = exact_least_power_of_boxes(a, b, shift, INT_MAX);
    exact_way(n->t, a->centre, b->centre, shift, power, n->term);
    for (int i = 0; i < 3; ++i) {
        exact_integer(n->half_a[i], a->half_extents[i], power);
        exact_integer(n->half_b[i], b->half_extents[i], power);
    }
}

static void set_numbers(numbers *n, const duet_pose *a, const duet_pose *b, const double shift[3])
{
    set_lengths(n, a, b, shift);
    exact_axes(n->axis_a, n->norm_a, n->q, a->rotation);
    exact_axes(n->axis_b, n->norm_b, n->q, b->rotation);
    mpz_mul(n->norms, n->norm_a, n->norm_b);
    for (int i = 0; i < 3; ++i) {
        exact_dot(n->t_a[i], n->t, n->axis_a[i]);
        exact_dot(n->t_b[i], n->t, n->axis_b[i]);
        for (int j = 0; j < 3; ++j) {
            exact_dot(n->c[i][j], n->axis_a[i], n->axis_b[j]);
            mpz_abs(n->by_a[i][j], n->c[i][j]);
            mpz_abs(n->by_b[j][i], n->c[i][j]);
        }
    }
}

// One face of a box: the distance along its axis, its half extent, and what of
// the other box lies along it.
static bool face_separates(numbers *n, const mpz_t along, const mpz_t half, const mpz_t norm_other,
                           mpz_t half_other[3], mpz_t cosines[3])
{
    mpz_mul(n->distance, along, norm_other);
    mpz_mul(n->reach, n->norms, half);
    for (int k = 0; k < 3; ++k)
        mpz_addmul(n->reach, half_other[k], cosines[k]);
    return mpz_cmpabs(n->distance, n->reach) > 0;
}

static bool edges_separate(numbers *n, int i, int j)
{
    int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    mpz_mul(n->distance, n->t_a[i2], n->c[i1][j]);
    mpz_submul(n->distance, n->t_a[i1], n->c[i2][j]);
    mpz_mul(n->reach, n->half_a[i1], n->by_a[i2][j]);
    mpz_addmul(n->reach, n->half_a[i2], n->by_a[i1][j]);
    mpz_addmul(n->reach, n->half_b[j1], n->by_a[i][j2]);
    mpz_addmul(n->reach, n->half_b[j2], n->by_a[i][j1]);
    mpz_mul(n->reach, n->reach, n->norm_a);
    return mpz_cmpabs(n->distance, n->reach) > 0;
}

// The axes of a flat box along z and across compare 0 with 0 too, so that 2D
// needs no case of its own.
static bool any_axis_separates(numbers *n)
{
    for (int i = 0; i < 3; ++i)
        if (face_separates(n, n->t_a[i], n->half_a[i], n->norm_b, n->half_b, n->by_a[i]) ||
            face_separates(n, n->t_b[i], n->half_b[i], n->norm_a, n->half_a, n->by_b[i]))
            return true;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (edges_separate(n, i, j))
                return true;
    return false;
}

bool narrow_exact(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    return narrow_exact_apart(a, b, narrow_here, dims);
}

bool narrow_exact_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                        uint32_t dims)
{
    if (!narrow_is_box(a, dims) || !narrow_is_box(b, dims))
        return false;
    duet_pose flat_a = narrow_flat(a, dims), flat_b = narrow_flat(b, dims);
    const double flat_shift[3] = {shift[0], shift[1], dims == 3 ? shift[2] : 0};
    numbers n;
    exact_open(&n, sizeof n);
    set_numbers(&n, &flat_a, &flat_b, flat_shift);
    bool separated = any_axis_separates(&n);
    exact_close(&n, sizeof n);
    return !separated;
}

// ---------------------------------------------------------------- two rounded boxes

// The two cores in integers: lengths share a power of two, an axis has the length of its
// quaternion's square. Cores that do not meet are nearest where a corner of one is nearest to the
// other, or inside two edges, so these cases are enough. Nothing is divided: with
// n = |qa|^2 |qb|^2 a distance d is n d, and what is compared are squares.
typedef struct core {
    mpz_t half[3];
    mpz_t axis[3][3];
    mpz_t norm;
} core;

typedef struct core_numbers {
    core a, b;
    mpz_t t[3]; // from a's centre to b's
    mpz_t q[4];
    mpz_t reach, norms, limit; // n times the reach, squared
    mpz_t way[3];              // n times
    mpz_t across[3], squared;
    mpz_t moment[3];
    mpz_t at, bound, term;
} core_numbers;

static void set_core_lengths(core_numbers *n, const duet_rounded_box *a, const duet_rounded_box *b)
{
    const float radii[2] = {a->radius, b->radius};
    int power = exact_least_power(radii, 2, INT_MAX);
    power = exact_least_power_of_boxes(&a->pose, &b->pose, narrow_here, power);
    exact_integer(n->reach, radii[0], power);
    exact_integer(n->term, radii[1], power);
    mpz_add(n->reach, n->reach, n->term);
    exact_way(n->t, a->pose.centre, b->pose.centre, narrow_here, power, n->term);
    for (int k = 0; k < 3; ++k) {
        exact_integer(n->a.half[k], a->pose.half_extents[k], power);
        exact_integer(n->b.half[k], b->pose.half_extents[k], power);
    }
}

static void set_core_numbers(core_numbers *n, const duet_rounded_box *a, const duet_rounded_box *b)
{
    set_core_lengths(n, a, b);
    exact_axes(n->a.axis, n->a.norm, n->q, a->pose.rotation);
    exact_axes(n->b.axis, n->b.norm, n->q, b->pose.rotation);
    mpz_mul(n->norms, n->a.norm, n->b.norm);
    mpz_mul(n->limit, n->reach, n->norms);
    mpz_mul(n->limit, n->limit, n->limit);
}

// way = n t
static void begin_way(core_numbers *n)
{
    for (int k = 0; k < 3; ++k)
        mpz_mul(n->way[k], n->norms, n->t[k]);
}

// way += n (-1)^away the half of edge i of a side, in the direction of bit i; but for edge `but`.
static void add_halves(core_numbers *n, const core *s, const mpz_t norm_other, int bits, int but,
                       bool away)
{
    for (int i = 0; i < 3; ++i) {
        if (i == but)
            continue;
        mpz_mul(n->term, s->half[i], norm_other);
        bool plus = ((bits >> i & 1) != 0) != away;
        for (int k = 0; k < 3; ++k)
            (plus ? mpz_addmul : mpz_submul)(n->way[k], n->term, s->axis[i][k]);
    }
}

// Whether bits names a corner, or with `but` an edge, that none before it was: an edge of no
// length has one end.
static bool is_first(const core *s, int bits, int but)
{
    for (int i = 0; i < 3; ++i)
        if ((bits >> i & 1) && (i == but || mpz_sgn(s->half[i]) == 0))
            return false;
    return true;
}

// Whether the point at n times `way` from the box's centre is within reach of the box.
static bool is_near_box(core_numbers *n, core *box)
{
    mpz_set_ui(n->squared, 0);
    for (int i = 0; i < 3; ++i) {
        exact_dot(n->at, n->way, box->axis[i]);
        mpz_abs(n->at, n->at);
        mpz_mul(n->bound, n->norms, box->half[i]);
        mpz_submul(n->at, n->bound, box->norm);
        if (mpz_sgn(n->at) > 0)
            mpz_addmul(n->squared, n->at, n->at);
    }
    mpz_mul(n->bound, n->limit, box->norm);
    mpz_mul(n->bound, n->bound, box->norm);
    return mpz_cmp(n->squared, n->bound) <= 0;
}

// In a's frame b's corners are ahead of t; in b's frame a's corners are back from it.
static bool any_corner_is_near(core_numbers *n, core *box, core *other, bool away)
{
    for (int bits = 0; bits < 8; ++bits) {
        if (!is_first(other, bits, -1))
            continue;
        begin_way(n);
        add_halves(n, other, box->norm, bits, -1, away);
        if (is_near_box(n, box))
            return true;
    }
    return false;
}

// Whether the point of one line that is nearest to the other lies in its edge: `along` is the
// other's direction, half and norm are the edge's.
static bool is_inside(core_numbers *n, mpz_t along[3], const mpz_t half, const mpz_t norm_other)
{
    exact_cross(n->moment, n->way, along);
    exact_dot(n->at, n->moment, n->across);
    mpz_mul(n->bound, half, norm_other);
    mpz_mul(n->bound, n->bound, n->squared);
    return mpz_cmpabs(n->at, n->bound) <= 0;
}

static bool edges_are_near(core_numbers *n, int i, int j)
{
    if (!is_inside(n, n->b.axis[j], n->a.half[i], n->b.norm) ||
        !is_inside(n, n->a.axis[i], n->b.half[j], n->a.norm))
        return false;
    exact_dot(n->at, n->way, n->across);
    mpz_mul(n->at, n->at, n->at);
    mpz_mul(n->bound, n->limit, n->squared);
    return mpz_cmp(n->at, n->bound) <= 0;
}

static bool any_edges_are_near(core_numbers *n)
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            exact_cross(n->across, n->a.axis[i], n->b.axis[j]);
            exact_dot(n->squared, n->across, n->across);
            bool skew =
                mpz_sgn(n->squared) > 0 && mpz_sgn(n->a.half[i]) > 0 && mpz_sgn(n->b.half[j]) > 0;
            for (int bits = 0; skew && bits < 64; ++bits) {
                if (!is_first(&n->a, bits & 7, i) || !is_first(&n->b, bits >> 3, j))
                    continue;
                begin_way(n);
                add_halves(n, &n->a, n->b.norm, bits & 7, i, true);
                add_halves(n, &n->b, n->a.norm, bits >> 3, j, false);
                if (edges_are_near(n, i, j))
                    return true;
            }
        }
    return false;
}

bool rounded_exact(const duet_rounded_box *first, const duet_rounded_box *second, uint32_t dims)
{
    if (!rounded_is_sound(first, dims) || !rounded_is_sound(second, dims))
        return false;
    duet_rounded_box a = rounded_flat(first, dims), b = rounded_flat(second, dims);
    if (narrow_exact(&a.pose, &b.pose, dims))
        return true;
    core_numbers n;
    exact_open(&n, sizeof n);
    set_core_numbers(&n, &a, &b);
    bool near = any_corner_is_near(&n, &n.a, &n.b, false) ||
                any_corner_is_near(&n, &n.b, &n.a, true) || any_edges_are_near(&n);
    exact_close(&n, sizeof n);
    return near;
}
