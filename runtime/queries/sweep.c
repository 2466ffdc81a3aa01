// SPDX-License-Identifier: MIT
// As kernels/queries/sweep.clh, with the unit of rounding of a double; then by integers.
//
// The other box and the moving one, taken away from each other, are a body of whose faces each
// is across one of 15 axes, and the way is a segment or a half-line through it. So the
// axes that can separate them are those, and the products of the way with the boxes' edges.
#include "runtime/queries/sweep.h"

#include "runtime/narrowphase/exact.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/vector.h"

#include <math.h>

// ---------------------------------------------------------------- double

#define SLACK (160 * 0x1p-53)
#define SLOW 0x1p-60
#define PARALLEL 0x1p-22

typedef enum met { MISSED, MET, OPEN } met;

typedef struct interval {
    double enter, leave;
    bool open;
} interval;

typedef struct passage {
    double doubt, lost, length;
    interval maybe, surely[2]; // by all axes, by those that are not across parallel edges
    double enter;
    double normal[3];
    double apart; // at the begin, along the axis where they are the most
} passage;

static void narrow_to(interval *of, double enter, double leave)
{
    of->enter = fmax(of->enter, enter);
    of->leave = fmin(of->leave, leave);
}

static void keep_normal(passage *p, double enter, double speed, const double axis[3])
{
    double length = sqrt(dot(axis, axis));
    if (enter <= p->enter || length == 0)
        return;
    p->enter = enter;
    for (int k = 0; k < 3; ++k)
        p->normal[k] = (speed > 0 ? -axis[k] : axis[k]) / length;
}

static bool pass_axis(passage *p, const double axis[3], double at, double speed, double reach,
                      bool parallel)
{
    double narrow = p->doubt + p->lost, beyond = fabs(at) - reach;
    p->apart = fmax(p->apart, beyond);
    if (fabs(speed) <= SLOW * p->length) {
        p->surely[0].open |= beyond > -p->doubt;
        p->surely[1].open |= !parallel && beyond > -narrow;
        return beyond <= p->doubt;
    }
    double inverse = 1 / fabs(speed), from = speed > 0 ? at : -at;
    double in = (-reach - from) * inverse, out = (reach - from) * inverse;
    narrow_to(&p->maybe, in - p->doubt * inverse, out + p->doubt * inverse);
    narrow_to(&p->surely[0], in + p->doubt * inverse, out - p->doubt * inverse);
    if (!parallel) {
        narrow_to(&p->surely[1], in + narrow * inverse, out - narrow * inverse);
        keep_normal(p, in, speed, axis);
    }
    return p->maybe.enter <= p->maybe.leave;
}

// Both boxes from each other: a moves.
typedef struct frame {
    double a[3], b[3], axis_a[3][3], axis_b[3][3];
    double at_a[3], at_b[3], go_a[3], go_b[3]; // along their edges
    double c[3][3];
} frame;

static double tilt_of(const frame *f, int i, int j)
{
    return fabs(f->c[i][(j + 1) % 3]) + fabs(f->c[i][(j + 2) % 3]);
}

static frame frame_of(const duet_sweep *sweep, const duet_pose *box, const double shift[3],
                      passage *p)
{
    frame f;
    double way[3], direction[3], size = 0, tilt = 0, widest_a = 0, widest_b = 0;
    narrow_axes(f.axis_a, sweep->box.rotation);
    narrow_axes(f.axis_b, box->rotation);
    for (int k = 0; k < 3; ++k) {
        way[k] = (double)sweep->box.centre[k] - box->centre[k] + shift[k];
        direction[k] = sweep->direction[k];
        f.a[k] = sweep->box.half_extents[k];
        f.b[k] = box->half_extents[k];
        widest_a = fmax(widest_a, f.a[k]);
        widest_b = fmax(widest_b, f.b[k]);
        size += fabs(way[k]) + f.a[k] + f.b[k];
        p->length = fmax(p->length, fabs(direction[k]));
    }
    for (int i = 0; i < 3; ++i) {
        f.at_a[i] = dot(f.axis_a[i], way);
        f.at_b[i] = dot(f.axis_b[i], way);
        f.go_a[i] = dot(f.axis_a[i], direction);
        f.go_b[i] = dot(f.axis_b[i], direction);
        for (int j = 0; j < 3; ++j)
            f.c[i][j] = dot(f.axis_a[i], f.axis_b[j]);
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            tilt = fmax(tilt, tilt_of(&f, i, j) < PARALLEL ? tilt_of(&f, i, j) : 0);
    p->lost = tilt * fmin(widest_a, widest_b);
    p->doubt = SLACK * size;
    p->maybe.leave = p->length > 0 ? sweep->t_max : 0;
    p->surely[0] = p->surely[1] = p->maybe;
    p->surely[0].open = p->surely[1].open = !(size > 0x1p-140); // underflows could count
    return f;
}

static bool pass_faces(passage *p, const frame *f, int i)
{
    double of_a = f->a[i], of_b = f->b[i];
    for (int k = 0; k < 3; ++k) {
        of_a += f->b[k] * fabs(f->c[i][k]);
        of_b += f->a[k] * fabs(f->c[k][i]);
    }
    return pass_axis(p, f->axis_a[i], f->at_a[i], f->go_a[i], of_a, false) &&
           pass_axis(p, f->axis_b[i], f->at_b[i], f->go_b[i], of_b, false);
}

static bool pass_edges(passage *p, const frame *f, int i, int j)
{
    int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    double at = f->at_a[i2] * f->c[i1][j] - f->at_a[i1] * f->c[i2][j];
    double go = f->go_a[i2] * f->c[i1][j] - f->go_a[i1] * f->c[i2][j];
    double reach = f->a[i1] * fabs(f->c[i2][j]) + f->a[i2] * fabs(f->c[i1][j]) +
                   f->b[j1] * fabs(f->c[i][j2]) + f->b[j2] * fabs(f->c[i][j1]);
    double axis[3];
    cross(axis, f->axis_a[i], f->axis_b[j]);
    return pass_axis(p, axis, at, go, reach, tilt_of(f, i, j) < PARALLEL);
}

static bool may_meet(passage *p, const frame *f, int dims)
{
    bool may = true;
    for (int i = 0; may && i < dims; ++i)
        may = pass_faces(p, f, i);
    for (int i = 0; may && dims == 3 && i < 9; ++i)
        may = pass_edges(p, f, i / 3, i % 3);
    return may;
}

static bool is_sure(const interval *i)
{
    return !i->open && i->enter <= i->leave;
}

static duet_sweep flat_sweep(const duet_sweep *sweep, uint32_t dims)
{
    duet_sweep flat = *sweep;
    flat.box = narrow_flat(&sweep->box, dims);
    if (dims == 2)
        flat.direction[2] = 0;
    return flat;
}

static met meet_in_double(const duet_sweep *sweep, const duet_pose *box, const double shift[3],
                          int dims)
{
    passage p = {0};
    frame f = frame_of(sweep, box, shift, &p);
    bool known = !p.surely[0].open;
    if (!may_meet(&p, &f, dims) && known)
        return MISSED;
    return is_sure(&p.surely[0]) || is_sure(&p.surely[1]) ? MET : OPEN;
}

// Trims the report: no t above t_max, no 0 below 0, and no normal where t is 0.
static float report(const passage *p, float t_max, float normal[3])
{
    float rounded = (float)p->enter, t = rounded < t_max ? rounded : t_max;
    for (int k = 0; k < 3; ++k)
        normal[k] = t > 0 ? (float)p->normal[k] + 0.0f : 0.0f;
    return t;
}

float sweep_enter_apart(const duet_sweep *sweep, const duet_pose *box, const double shift[3],
                        uint32_t dims, float normal[3])
{
    duet_sweep flat = flat_sweep(sweep, dims);
    duet_pose pose = narrow_flat(box, dims);
    const double flat_shift[3] = {shift[0], shift[1], dims == 3 ? shift[2] : 0};
    passage p = {0};
    frame f = frame_of(&flat, &pose, flat_shift, &p);
    may_meet(&p, &f, (int)dims);
    if (p.enter > 0 && p.apart <= p.doubt && narrow_decide_apart(box, &sweep->box, shift, dims))
        p.enter = 0;
    return report(&p, sweep->t_max, normal);
}

float sweep_enter(const duet_sweep *sweep, const duet_pose *box, uint32_t dims, float normal[3])
{
    return sweep_enter_apart(sweep, box, narrow_here, dims, normal);
}

float sweep_enter_bounds(const duet_bounds_sweep *sweep, const duet_bounds *box, uint32_t dims,
                         float normal[3])
{
    passage p = {0};
    for (uint32_t k = 0; k < dims; ++k) {
        double axis[3] = {k == 0, k == 1, k == 2}, speed = sweep->direction[k];
        double gap = speed > 0 ? (double)box->lower[k] - sweep->bounds.upper[k]
                               : (double)box->upper[k] - sweep->bounds.lower[k];
        if (speed != 0)
            keep_normal(&p, gap / speed, speed, axis);
    }
    return report(&p, sweep->t_max, normal);
}

// ---------------------------------------------------------------- integers

typedef struct numbers {
    mpz_t q[4], norm_a, norm_b, norms;
    mpz_t axis_a[3][3], axis_b[3][3];
    mpz_t half_a[3], half_b[3];
    mpz_t way[3], step[3]; // from b to a; then exact_step's
    mpz_t axis[3];         // that is tried
    mpz_t at, end, reach, part, term;
} numbers;

static void set_numbers(numbers *n, const duet_sweep *sweep, const duet_pose *box,
                        const double shift[3])
{
    int power = exact_least_power_of_boxes(&sweep->box, box, shift, 0);
    power = exact_step(n->step, sweep->direction, sweep->t_max, power);
    exact_axes(n->axis_a, n->norm_a, n->q, sweep->box.rotation);
    exact_axes(n->axis_b, n->norm_b, n->q, box->rotation);
    mpz_mul(n->norms, n->norm_a, n->norm_b);
    for (int k = 0; k < 3; ++k) {
        exact_integer(n->half_a[k], sweep->box.half_extents[k], power);
        exact_integer(n->half_b[k], box->half_extents[k], power);
    }
    exact_way(n->way, box->centre, sweep->box.centre, shift, power, n->term);
}

// All of it twice as long, so that the middle of bounds is an integer too.
static void set_bounds_numbers(numbers *n, const duet_bounds_sweep *sweep, const duet_bounds *box)
{
    int power = exact_least_power(sweep->bounds.lower, 3, 0);
    power = exact_least_power(sweep->bounds.upper, 3, power);
    power = exact_least_power(box->lower, 3, power);
    power = exact_least_power(box->upper, 3, power);
    power = exact_step(n->step, sweep->direction, sweep->t_max, power);
    mpz_set_ui(n->norm_a, 1);
    mpz_set_ui(n->norm_b, 1);
    mpz_set_ui(n->norms, 1);
    for (int k = 0; k < 3; ++k) {
        mpz_set_ui(n->axis_a[k][k], 1);
        mpz_set_ui(n->axis_b[k][k], 1);
        exact_integer(n->at, sweep->bounds.lower[k], power);
        exact_integer(n->end, sweep->bounds.upper[k], power);
        mpz_sub(n->half_a[k], n->end, n->at);
        mpz_add(n->way[k], n->end, n->at);
        exact_integer(n->at, box->lower[k], power);
        exact_integer(n->end, box->upper[k], power);
        mpz_sub(n->half_b[k], n->end, n->at);
        mpz_sub(n->way[k], n->way[k], n->at);
        mpz_sub(n->way[k], n->way[k], n->end);
        mpz_mul_2exp(n->step[k], n->step[k], 1);
    }
}

// How far a box reaches along n->axis, times the norms of both.
static void add_reach(numbers *n, mpz_t half[3], mpz_t axis[3][3], const mpz_t norm_other)
{
    mpz_set_ui(n->part, 0);
    for (int i = 0; i < 3; ++i) {
        exact_dot(n->term, axis[i], n->axis);
        mpz_abs(n->term, n->term);
        mpz_addmul(n->part, half[i], n->term);
    }
    mpz_addmul(n->reach, n->part, norm_other);
}

// Begin and end are beyond the same side; an axis of no length separates nothing.
static bool separates(numbers *n, bool ends)
{
    mpz_set_ui(n->reach, 0);
    add_reach(n, n->half_a, n->axis_a, n->norm_b);
    add_reach(n, n->half_b, n->axis_b, n->norm_a);
    exact_dot(n->at, n->way, n->axis);
    mpz_mul(n->at, n->at, n->norms);
    if (mpz_cmpabs(n->at, n->reach) <= 0)
        return false;
    int side = mpz_sgn(n->at);
    exact_dot(n->end, n->step, n->axis);
    if (!ends)
        return side * mpz_sgn(n->end) >= 0;
    mpz_addmul(n->at, n->end, n->norms);
    return mpz_sgn(n->at) == side && mpz_cmpabs(n->at, n->reach) > 0;
}

static bool axis_separates(numbers *n, mpz_t u[3], bool ends)
{
    for (int k = 0; k < 3; ++k)
        mpz_set(n->axis[k], u[k]);
    return separates(n, ends);
}

static bool product_separates(numbers *n, mpz_t u[3], mpz_t v[3], bool ends)
{
    exact_cross(n->axis, u, v);
    return separates(n, ends);
}

static bool any_axis_separates(numbers *n, bool ends)
{
    for (int i = 0; i < 3; ++i)
        if (axis_separates(n, n->axis_a[i], ends) || axis_separates(n, n->axis_b[i], ends) ||
            product_separates(n, n->step, n->axis_a[i], ends) ||
            product_separates(n, n->step, n->axis_b[i], ends))
            return true;
    for (int i = 0; i < 9; ++i)
        if (product_separates(n, n->axis_a[i / 3], n->axis_b[i % 3], ends))
            return true;
    return false;
}

// They are flat.
static bool meet_in_integers(const duet_sweep *sweep, const duet_pose *box, const double shift[3])
{
    numbers n;
    exact_open(&n, sizeof n);
    set_numbers(&n, sweep, box, shift);
    bool separated = any_axis_separates(&n, isfinite(sweep->t_max));
    exact_close(&n, sizeof n);
    return !separated;
}

bool sweep_meets_exactly(const duet_sweep *sweep, const duet_pose *box, uint32_t dims)
{
    duet_sweep flat = flat_sweep(sweep, dims);
    duet_pose pose = narrow_flat(box, dims);
    return meet_in_integers(&flat, &pose, narrow_here);
}

bool sweep_meets_bounds(const duet_bounds_sweep *sweep, const duet_bounds *box, uint32_t dims)
{
    duet_bounds_sweep flat = *sweep;
    duet_bounds bounds = *box;
    numbers n;
    if (dims == 2)
        flat.direction[2] = flat.bounds.lower[2] = flat.bounds.upper[2] = bounds.lower[2] =
            bounds.upper[2] = 0;
    exact_open(&n, sizeof n);
    set_bounds_numbers(&n, &flat, &bounds);
    bool separated = any_axis_separates(&n, isfinite(sweep->t_max));
    exact_close(&n, sizeof n);
    return !separated;
}

bool sweep_meets_apart(const duet_sweep *sweep, const duet_pose *box, const double shift[3],
                       uint32_t dims)
{
    duet_sweep flat = flat_sweep(sweep, dims);
    duet_pose pose = narrow_flat(box, dims);
    const double flat_shift[3] = {shift[0], shift[1], dims == 3 ? shift[2] : 0};
    met found = meet_in_double(&flat, &pose, flat_shift, (int)dims);
    return found == OPEN ? meet_in_integers(&flat, &pose, flat_shift) : found == MET;
}

bool sweep_meets(const duet_sweep *sweep, const duet_pose *box, uint32_t dims)
{
    return sweep_meets_apart(sweep, box, narrow_here, dims);
}
