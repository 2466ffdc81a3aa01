// SPDX-License-Identifier: MIT
// Whether a moving box meets a piece of a ground, in rational numbers: as ground_meet.c, without
// an error.
#include "runtime/narrowphase/ground_piece.h"

#include <gmp.h>
#include <math.h>

// The box's axes are as long as `norm` says.
typedef struct numbers {
    mpq_t q[4], norm, axis[3][3], centre[3], half[3], go[3];
    mpq_t corner[3][3], edge[3][3], up[3], normal[3];
    mpq_t way[3], at, best, speed, enter, leave, term, other;
} numbers;

typedef struct state {
    numbers n;
    bool ends;
    int entered;
} state;

static void open_numbers(numbers *n)
{
    for (mpq_t *at = (mpq_t *)n; at < (mpq_t *)(n + 1); ++at)
        mpq_init(*at);
}

static void close_numbers(numbers *n)
{
    for (mpq_t *at = (mpq_t *)n; at < (mpq_t *)(n + 1); ++at)
        mpq_clear(*at);
}

static void set_dot(numbers *n, mpq_t out, mpq_t u[3], mpq_t v[3])
{
    mpq_set_ui(out, 0, 1);
    for (int k = 0; k < 3; ++k) {
        mpq_mul(n->term, u[k], v[k]);
        mpq_add(out, out, n->term);
    }
}

static void set_cross(numbers *n, mpq_t out[3], mpq_t u[3], mpq_t v[3])
{
    for (int k = 0; k < 3; ++k) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        mpq_mul(out[k], u[a], v[b]);
        mpq_mul(n->term, u[b], v[a]);
        mpq_sub(out[k], out[k], n->term);
    }
}

// ---------------------------------------------------------------- what is given

// 2 (q_a q_b + sign q_w q_c)
static void set_entry(numbers *n, mpq_t out, int a, int b, int c, int sign)
{
    mpq_mul(out, n->q[a], n->q[b]);
    mpq_mul(n->term, n->q[3], n->q[c]);
    (sign > 0 ? mpq_add : mpq_sub)(out, out, n->term);
    mpq_mul_2exp(out, out, 1);
}

// axis[i][k] is entry k, i of the matrix of a quaternion, times the square of its length.
static void set_axes(numbers *n, const float rotation[4])
{
    for (int k = 0; k < 4; ++k) {
        mpq_set_d(n->q[k], rotation[k]);
        mpq_mul(n->term, n->q[k], n->q[k]);
        mpq_add(n->norm, n->norm, n->term);
    }
    for (int i = 0; i < 3; ++i) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        mpq_mul(n->axis[i][i], n->q[a], n->q[a]);
        mpq_mul(n->term, n->q[b], n->q[b]);
        mpq_add(n->axis[i][i], n->axis[i][i], n->term);
        mpq_mul_2exp(n->axis[i][i], n->axis[i][i], 1);
        mpq_sub(n->axis[i][i], n->norm, n->axis[i][i]);
        set_entry(n, n->axis[i][a], i, a, b, 1);
        set_entry(n, n->axis[i][b], i, b, a, -1);
    }
}

// Half the sum and half the difference of two corners.
static void set_extent(numbers *n, int k, float lower, float upper)
{
    mpq_set_d(n->centre[k], upper);
    mpq_set_d(n->half[k], upper);
    mpq_set_d(n->term, lower);
    mpq_add(n->centre[k], n->centre[k], n->term);
    mpq_sub(n->half[k], n->half[k], n->term);
    mpq_div_2exp(n->centre[k], n->centre[k], 1);
    mpq_div_2exp(n->half[k], n->half[k], 1);
}

static void set_given(numbers *n, const ground_piece *p, const ground_probe *probe)
{
    set_axes(n, probe->rotation);
    for (int k = 0; k < 3; ++k) {
        mpq_set_d(n->centre[k], probe->centre[k]);
        mpq_set_d(n->half[k], probe->half[k]);
        if (probe->bounds)
            set_extent(n, k, probe->bounds->lower[k], probe->bounds->upper[k]);
        mpq_set_d(n->go[k], probe->direction[k]);
        for (int i = 0; i < 3; ++i)
            mpq_set_d(n->corner[i][k], p->corner[i][k]);
        for (int i = 0; i < 3; ++i)
            mpq_sub(n->edge[i][k], n->corner[(i + 1) % 3][k], n->corner[i][k]);
    }
    mpq_set_ui(n->up[2], 1, 1);
    if (p->is_sheet)
        set_cross(n, n->up, n->edge[0], n->edge[1]);
}

// ---------------------------------------------------------------- axes

static void set_normal(numbers *n, int k)
{
    int axis, edge;
    if (k < PIECE_TOP || k >= 16) {
        set_cross(n, n->normal, k < PIECE_TOP ? n->edge[k] : n->axis[k - 16], n->up);
    } else if (k == PIECE_TOP) {
        set_cross(n, n->normal, n->edge[0], n->edge[1]);
    } else if (piece_axis_is_product(k, &axis, &edge)) {
        set_cross(n, n->normal, n->axis[axis], n->edge[edge]);
    } else {
        for (int i = 0; i < 3; ++i)
            mpq_set(n->normal[i], n->axis[k - PIECE_PLANES][i]);
    }
}

static void negate_normal(numbers *n)
{
    for (int k = 0; k < 3; ++k)
        mpq_neg(n->normal[k], n->normal[k]);
}

// How far the box reaches into the piece along the normal is at + t speed, times norm.
static void set_within(numbers *n)
{
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            mpq_sub(n->way[k], n->corner[i][k], n->centre[k]);
        set_dot(n, n->at, n->way, n->normal);
        if (i == 0 || mpq_cmp(n->at, n->best) > 0)
            mpq_set(n->best, n->at);
    }
    mpq_mul(n->at, n->best, n->norm);
    for (int k = 0; k < 3; ++k) {
        set_dot(n, n->other, n->axis[k], n->normal);
        mpq_abs(n->other, n->other);
        mpq_mul(n->other, n->other, n->half[k]);
        mpq_add(n->at, n->at, n->other);
    }
    set_dot(n, n->speed, n->go, n->normal);
    mpq_mul(n->speed, n->speed, n->norm);
    mpq_neg(n->speed, n->speed);
}

// Whether some of the way is left.
static bool cut(state *s, int k)
{
    numbers *n = &s->n;
    set_within(n);
    int speed = mpq_sgn(n->speed);
    if (speed == 0)
        return mpq_sgn(n->at) >= 0;
    mpq_div(n->other, n->at, n->speed);
    mpq_neg(n->other, n->other);
    if (speed > 0 && mpq_cmp(n->other, n->enter) > 0) {
        mpq_set(n->enter, n->other);
        s->entered = k;
    } else if (speed < 0 && (!s->ends || mpq_cmp(n->other, n->leave) < 0)) {
        mpq_set(n->leave, n->other);
        s->ends = true;
    }
    return !s->ends || mpq_cmp(n->enter, n->leave) <= 0;
}

// A prism has no end below: only axes that do not point down separate.
static bool cut_by_axis(state *s, bool is_sheet, int k)
{
    set_normal(&s->n, k);
    int up = mpq_sgn(s->n.normal[2]);
    if (!is_sheet && up < 0)
        negate_normal(&s->n);
    if (!cut(s, k))
        return false;
    if (!is_sheet && (up != 0 || k < PIECE_TOP))
        return true;
    negate_normal(&s->n);
    return cut(s, k);
}

bool ground_piece_meet_exactly(const ground_piece *p, const ground_probe *probe, double *t,
                               int *entered)
{
    state s = {.ends = isfinite(probe->t_max), .entered = -1};
    bool meets = true;
    open_numbers(&s.n);
    set_given(&s.n, p, probe);
    if (s.ends)
        mpq_set_d(s.n.leave, probe->t_max);
    for (int k = 0; meets && k < (probe->is_point ? PIECE_PLANES : PIECE_AXES); ++k)
        meets = cut_by_axis(&s, p->is_sheet, k);
    *t = mpq_get_d(s.n.enter);
    *entered = s.entered;
    close_numbers(&s.n);
    return meets;
}
