// SPDX-License-Identifier: MIT
#include "support/oracle.h"

#include <gmp.h>
#include <math.h>
#include <string.h>

// Twelve inequalities, at most 6 * 6 after one elimination, 18 * 18 after two.
enum { MOST_ROWS = 324 };

// x[0] p0 + x[1] p1 + x[2] p2 <= x[3]
typedef struct row {
    mpz_t x[4];
} row;

typedef struct rows {
    row at[MOST_ROWS];
    int n;
} rows;

static void open_rows(rows *r)
{
    r->n = 0;
    for (int i = 0; i < MOST_ROWS; ++i)
        for (int k = 0; k < 4; ++k)
            mpz_init(r->at[i].x[k]);
}

static void close_rows(rows *r)
{
    for (int i = 0; i < MOST_ROWS; ++i)
        for (int k = 0; k < 4; ++k)
            mpz_clear(r->at[i].x[k]);
}

// Every float is a whole number of 2^-149, every double one of 2^-1074.
enum { FLOAT_GRAIN = 149, DOUBLE_GRAIN = 1074 };

// A box of such whole numbers.
typedef struct given_box {
    double centre[3], half_extents[3], rotation[4];
    int grain;
} given_box;

static void set_whole(mpz_t out, double value, int grain)
{
    int power;
    mpz_set_d(out, ldexp(frexp(value, &power), 53));
    power += grain - 53;
    if (power >= 0)
        mpz_mul_2exp(out, out, (mp_bitcnt_t)power);
    else
        mpz_tdiv_q_2exp(out, out, (mp_bitcnt_t)-power);
}

typedef struct quaternion {
    mpz_t v[4]; // x y z w
} quaternion;

static void open_quaternion(quaternion *q)
{
    for (int i = 0; i < 4; ++i)
        mpz_init(q->v[i]);
}

static void close_quaternion(quaternion *q)
{
    for (int i = 0; i < 4; ++i)
        mpz_clear(q->v[i]);
}

// out = p q, by the table of units: i j = k and so on.
static void multiply(quaternion *out, const quaternion *p, const quaternion *q)
{
    static const int unit[4][4] = {{3, 2, 1, 0}, {2, 3, 0, 1}, {1, 0, 3, 2}, {0, 1, 2, 3}};
    static const int sign[4][4] = {{-1, 1, -1, 1}, {-1, -1, 1, 1}, {1, -1, -1, 1}, {1, 1, 1, 1}};
    for (int i = 0; i < 4; ++i)
        mpz_set_ui(out->v[i], 0);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            (sign[i][j] > 0 ? mpz_addmul : mpz_submul)(out->v[unit[i][j]], p->v[i], q->v[j]);
}

// The edge's direction, of length |q|^2: q e q*. Its real part, which is 0,
// becomes |q|^2.
static void set_edge(quaternion *out, const given_box *box, int edge)
{
    quaternion q, conjugate, unit, half_way;
    open_quaternion(&q);
    open_quaternion(&conjugate);
    open_quaternion(&unit);
    open_quaternion(&half_way);
    for (int i = 0; i < 4; ++i) {
        set_whole(q.v[i], box->rotation[i], box->grain);
        set_whole(conjugate.v[i], i < 3 ? -box->rotation[i] : box->rotation[i], box->grain);
        mpz_set_si(unit.v[i], i == edge);
    }
    multiply(&half_way, &q, &unit);
    multiply(out, &half_way, &conjugate);
    mpz_set_ui(out->v[3], 0);
    for (int i = 0; i < 4; ++i)
        mpz_addmul(out->v[3], q.v[i], q.v[i]);
    close_quaternion(&q);
    close_quaternion(&conjugate);
    close_quaternion(&unit);
    close_quaternion(&half_way);
}

// sign * edge . (p - centre) <= half * |edge|
static void add_side(rows *r, const quaternion *edge, int sign, const given_box *box, double half)
{
    row *side = &r->at[r->n++];
    mpz_t whole;
    mpz_init(whole);
    set_whole(whole, half, box->grain);
    mpz_mul(side->x[3], whole, edge->v[3]);
    for (int i = 0; i < 3; ++i) {
        mpz_mul_si(side->x[i], edge->v[i], sign);
        set_whole(whole, box->centre[i], box->grain);
        mpz_addmul(side->x[3], whole, side->x[i]);
    }
    mpz_clear(whole);
}

static void add_box(rows *r, const given_box *box)
{
    quaternion edge;
    open_quaternion(&edge);
    for (int i = 0; i < 3; ++i) {
        set_edge(&edge, box, i);
        add_side(r, &edge, 1, box, box->half_extents[i]);
        add_side(r, &edge, -1, box, box->half_extents[i]);
    }
    close_quaternion(&edge);
}

// out = the rows that follow from `in` without coordinate k: each with a
// positive factor of it joined to each with a negative one.
static void eliminate(const rows *in, int k, rows *out)
{
    out->n = 0;
    for (int i = 0; i < in->n; ++i) {
        int sign = mpz_sgn(in->at[i].x[k]);
        if (sign == 0)
            for (int c = 0; c < 4; ++c)
                mpz_set(out->at[out->n].x[c], in->at[i].x[c]);
        out->n += sign == 0;
        for (int j = 0; sign > 0 && j < in->n; ++j) {
            if (mpz_sgn(in->at[j].x[k]) >= 0)
                continue;
            for (int c = 0; c < 4; ++c) {
                mpz_mul(out->at[out->n].x[c], in->at[j].x[c], in->at[i].x[k]);
                mpz_submul(out->at[out->n].x[c], in->at[i].x[c], in->at[j].x[k]);
            }
            ++out->n;
        }
    }
}

// Solves two rows in one coordinate: a p <= x and -b p <= y meet where a y + b x >= 0.
static bool has_solution(const rows *r, int k)
{
    bool solved = true;
    mpz_t sum;
    mpz_init(sum);
    for (int i = 0; solved && i < r->n; ++i) {
        int sign = mpz_sgn(r->at[i].x[k]);
        solved = sign != 0 || mpz_sgn(r->at[i].x[3]) >= 0;
        for (int j = 0; solved && sign > 0 && j < r->n; ++j) {
            if (mpz_sgn(r->at[j].x[k]) >= 0)
                continue;
            mpz_mul(sum, r->at[j].x[3], r->at[i].x[k]);
            mpz_submul(sum, r->at[i].x[3], r->at[j].x[k]);
            solved = mpz_sgn(sum) >= 0;
        }
    }
    mpz_clear(sum);
    return solved;
}

static bool collide(const given_box *a, const given_box *b)
{
    rows all, fewer;
    open_rows(&all);
    open_rows(&fewer);
    add_box(&all, a);
    add_box(&all, b);
    eliminate(&all, 0, &fewer);
    eliminate(&fewer, 1, &all);
    bool found = has_solution(&all, 2);
    close_rows(&all);
    close_rows(&fewer);
    return found;
}

static given_box box_of_pose(const duet_pose *pose, uint32_t dims)
{
    given_box box = {.grain = FLOAT_GRAIN};
    for (uint32_t i = 0; i < dims; ++i) {
        box.centre[i] = pose->centre[i];
        box.half_extents[i] = pose->half_extents[i];
    }
    for (uint32_t i = dims == 2 ? 2 : 0; i < 4; ++i)
        box.rotation[i] = pose->rotation[i];
    return box;
}

bool oracle_collide(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    given_box box_a = box_of_pose(a, dims), box_b = box_of_pose(b, dims);
    return collide(&box_a, &box_b);
}

static given_box box_of_numbers(const double given[10])
{
    given_box box = {.grain = DOUBLE_GRAIN};
    memcpy(box.centre, given, sizeof box.centre);
    memcpy(box.half_extents, given + 3, sizeof box.half_extents);
    memcpy(box.rotation, given + 6, sizeof box.rotation);
    return box;
}

bool oracle_rows_collide(const double a[10], const double b[10])
{
    given_box box_a = box_of_numbers(a), box_b = box_of_numbers(b);
    return collide(&box_a, &box_b);
}
