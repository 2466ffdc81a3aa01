// SPDX-License-Identifier: MIT
#include "runtime/queries/ray.h"

#include "runtime/narrowphase/exact.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/vector.h"

#include <math.h>
#include <string.h>

// ---------------------------------------------------------------- double

typedef enum met { MISSED, MET, OPEN } met;

// The bounds of kernels/queries/ray_query.cl, with the unit of rounding of a double.
#define SLACK (64 * 0x1p-53)
#define SLOW 0x1p-60

// A ray from a box: its origin and direction along the box's edges.
typedef struct approach {
    double axis[3][3], at[3], go[3];
    double size, length;
} approach;

// The difference of two offsets in origin cells is exact, so way is rounded once.
static approach approach_of(const duet_ray *ray, const duet_pose *box, const double shift[3],
                            int dims)
{
    approach a = {.size = 0};
    double way[3] = {0}, direction[3] = {0};
    narrow_axes(a.axis, box->rotation);
    for (int k = 0; k < dims; ++k) {
        way[k] = (double)ray->origin[k] - box->centre[k] + shift[k];
        direction[k] = ray->direction[k];
        a.size += fabs(way[k]) + box->half_extents[k];
        a.length = fmax(a.length, fabs(direction[k]));
    }
    for (int k = 0; k < dims; ++k) {
        a.at[k] = dot(a.axis[k], way);
        a.go[k] = dot(a.axis[k], direction);
    }
    return a;
}

static met meet_in_double(const duet_ray *ray, const duet_pose *box, const double shift[3],
                          int dims)
{
    const approach a = approach_of(ray, box, shift, dims);
    double doubt = SLACK * a.size, surely_enter = 0, maybe_enter = 0;
    double surely_leave = a.length > 0 ? ray->t_max : 0, maybe_leave = surely_leave;
    bool open = !(a.size > 0x1p-140); // underflows could count
    for (int k = 0; k < dims; ++k) {
        double speed = a.go[k], half = box->half_extents[k];
        if (fabs(speed) <= SLOW * a.length) {
            if (fabs(a.at[k]) > half + doubt)
                return open ? OPEN : MISSED;
            open = open || fabs(a.at[k]) > half - doubt;
            continue;
        }
        double at = speed > 0 ? a.at[k] : -a.at[k];
        double inverse = 1 / fabs(speed), in = (-half - at) * inverse, out = (half - at) * inverse;
        surely_enter = fmax(surely_enter, in + doubt * inverse);
        maybe_enter = fmax(maybe_enter, in - doubt * inverse);
        surely_leave = fmin(surely_leave, out - doubt * inverse);
        maybe_leave = fmin(maybe_leave, out + doubt * inverse);
    }
    if (maybe_enter > maybe_leave && !open)
        return MISSED;
    return !open && surely_enter <= surely_leave ? MET : OPEN;
}

// ---------------------------------------------------------------- integers

typedef struct numbers {
    mpz_t q[4], norm, axis[3][3];
    mpz_t way[3];       // from the box to the ray's origin
    mpz_t step[3];      // from there to its end; without an end, its direction
    mpz_t at[3], go[3]; // the two along the box's edges
    mpz_t reach[3];     // half extents, as long
    mpz_t radius;       // and so
    mpz_t from, per;    // a place on the way, from / per
    mpz_t left, right, term;
} numbers;

// Ways and half extents share a power of two with the step, unless that has no end.
static void set_numbers(numbers *n, const duet_ray *ray, const duet_pose *box,
                        const double shift[3], float radius)
{
    bool ends = isfinite(ray->t_max);
    const float t_max = ends ? ray->t_max : 1;
    int t_power = exact_least_power(&t_max, 1, 0);
    int v_power = exact_least_power(ray->direction, 3, 0);
    int power = exact_least_power(ray->origin, 3, ends ? t_power + v_power : 0);
    power = exact_least_power(&radius, 1, power);
    power = exact_least_power_of_boxes(box, box, shift, power);
    exact_axes(n->axis, n->norm, n->q, box->rotation);
    exact_integer(n->right, t_max, t_power);
    exact_integer(n->radius, radius, power);
    mpz_mul(n->radius, n->radius, n->norm);
    exact_way(n->way, box->centre, ray->origin, shift, power, n->left);
    for (int k = 0; k < 3; ++k) {
        exact_integer(n->step[k], ray->direction[k], v_power);
        if (ends) {
            mpz_mul(n->step[k], n->step[k], n->right);
            mpz_mul_2exp(n->step[k], n->step[k], (mp_bitcnt_t)(t_power + v_power - power));
        }
    }
    for (int k = 0; k < 3; ++k) {
        exact_dot(n->at[k], n->way, n->axis[k]);
        exact_dot(n->go[k], n->step, n->axis[k]);
        exact_integer(n->reach[k], box->half_extents[k], power);
        mpz_mul(n->reach[k], n->reach[k], n->norm);
    }
}

// Both ends are beyond one of the two faces.
static bool face_separates(numbers *n, int k, bool ends)
{
    if (mpz_cmpabs(n->at[k], n->reach[k]) <= 0)
        return false;
    int side = mpz_sgn(n->at[k]);
    if (!ends)
        return side * mpz_sgn(n->go[k]) >= 0;
    mpz_add(n->left, n->at[k], n->go[k]);
    return mpz_sgn(n->left) == side && mpz_cmpabs(n->left, n->reach[k]) > 0;
}

// Along the product of the ray and an edge.
static bool edge_separates(numbers *n, int i, int j)
{
    mpz_mul(n->left, n->at[i], n->go[j]);
    mpz_submul(n->left, n->at[j], n->go[i]);
    mpz_mul(n->right, n->reach[i], n->go[j]);
    mpz_mul(n->term, n->reach[j], n->go[i]);
    mpz_abs(n->right, n->right);
    mpz_abs(n->term, n->term);
    mpz_add(n->right, n->right, n->term);
    return mpz_cmpabs(n->left, n->right) > 0;
}

static bool is_separated(numbers *n, bool ends)
{
    for (int k = 0; k < 3; ++k)
        if (face_separates(n, k, ends) || edge_separates(n, k, (k + 1) % 3))
            return true;
    return false;
}

static duet_ray flat_ray(const duet_ray *ray, uint32_t dims)
{
    duet_ray flat = *ray;
    if (dims == 2)
        flat.origin[2] = flat.direction[2] = 0;
    return flat;
}

typedef bool check(numbers *n, bool ends);

static bool check_exactly(check *holds, const duet_ray *ray, const duet_pose *box,
                          const double shift[3], float radius, uint32_t dims)
{
    duet_ray flat = flat_ray(ray, dims);
    duet_pose pose = narrow_flat(box, dims);
    const double flat_shift[3] = {shift[0], shift[1], dims == 3 ? shift[2] : 0};
    numbers n;
    exact_open(&n, sizeof n);
    set_numbers(&n, &flat, &pose, flat_shift, radius);
    bool found = holds(&n, isfinite(ray->t_max));
    exact_close(&n, sizeof n);
    return found;
}

bool ray_meets_exactly(const duet_ray *ray, const duet_pose *box, uint32_t dims)
{
    return !check_exactly(is_separated, ray, box, narrow_here, 0, dims);
}

bool ray_meets_apart(const duet_ray *ray, const duet_pose *box, const double shift[3],
                     uint32_t dims)
{
    duet_ray flat = flat_ray(ray, dims);
    duet_pose pose = narrow_flat(box, dims);
    met found = meet_in_double(&flat, &pose, shift, (int)dims);
    return found == OPEN ? !check_exactly(is_separated, ray, box, shift, 0, dims) : found == MET;
}

bool ray_meets(const duet_ray *ray, const duet_pose *box, uint32_t dims)
{
    return ray_meets_apart(ray, box, narrow_here, dims);
}

// ---------------------------------------------------------------- rounded boxes

// Whether it is at from / per of the way.
static bool is_near(numbers *n)
{
    mpz_set_ui(n->right, 0);
    for (int k = 0; k < 3; ++k) {
        mpz_mul(n->left, n->at[k], n->per);
        mpz_addmul(n->left, n->go[k], n->from);
        mpz_abs(n->left, n->left);
        mpz_submul(n->left, n->reach[k], n->per);
        if (mpz_sgn(n->left) > 0)
            mpz_addmul(n->right, n->left, n->left);
    }
    mpz_mul(n->left, n->radius, n->per);
    mpz_mul(n->left, n->left, n->left);
    return mpz_cmp(n->right, n->left) <= 0;
}

// Sets from / per, the place along the way where the distance from what is beyond some of the faces
// is least: sides[k] is -1 or 1, or 0 for none of edge k's.
static void set_least(numbers *n, const int sides[3])
{
    mpz_set_ui(n->from, 0);
    mpz_set_ui(n->per, 0);
    for (int k = 0; k < 3; ++k) {
        if (sides[k] == 0)
            continue;
        (sides[k] > 0 ? mpz_sub : mpz_add)(n->left, n->at[k], n->reach[k]);
        mpz_submul(n->from, n->left, n->go[k]);
        mpz_addmul(n->per, n->go[k], n->go[k]);
    }
}

// The square of the distance is convex along the way, and its least value is at an end, or where
// that from some of the faces is least.
static bool comes_near(numbers *n, bool ends)
{
    mpz_set_ui(n->per, 1);
    for (unsigned end = 0; end <= ends; ++end) {
        mpz_set_ui(n->from, end);
        if (is_near(n))
            return true;
    }
    for (int i = 0; i < 27; ++i) {
        const int sides[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        set_least(n, sides);
        bool is_on = mpz_sgn(n->per) > 0 && mpz_sgn(n->from) >= 0 &&
                     (!ends || mpz_cmp(n->from, n->per) <= 0);
        if (is_on && is_near(n))
            return true;
    }
    return false;
}

// The way from the core to the ray at t, along the core's edges; returns its square.
static double beyond_core(const approach *a, const duet_pose *box, double t, double beyond[3])
{
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        double p = a->at[k] + t * a->go[k];
        beyond[k] = copysign(fmax(fabs(p) - box->half_extents[k], 0), p);
        square += beyond[k] * beyond[k];
    }
    return square;
}

// By Newton's method from before it, as kernels/queries/rounded_ray.clh.
static double enter(const approach *a, const duet_pose *box, double radius, double from)
{
    enum { STEPS = 200 };
    double surely = radius + SLACK * (a->size + radius); // further: a step is none of rounding's
    double t = from, beyond[3];
    for (int step = 0; step < STEPS; ++step) {
        double square = beyond_core(a, box, t, beyond), growth = dot(beyond, a->go);
        double next = t - (square - radius * radius) / (2 * growth);
        if (!(square > surely * surely && growth < 0 && next > t))
            break;
        t = next;
    }
    return t;
}

bool ray_meets_rounded(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims, float *t)
{
    if (!check_exactly(comes_near, ray, &box->pose, narrow_here, box->radius, dims))
        return false;
    duet_ray flat = flat_ray(ray, dims);
    duet_pose pose = narrow_flat(&box->pose, dims);
    approach a = approach_of(&flat, &pose, narrow_here, (int)dims);
    *t = fmaxf(*t, fminf((float)enter(&a, &pose, box->radius, *t), ray->t_max));
    return true;
}

// ---------------------------------------------------------------- normals

static duet_ray start_of(const duet_ray *ray)
{
    duet_ray start = *ray;
    start.t_max = 0;
    return start;
}

// A part of each edge's direction.
static void set_normal(const approach *a, const double parts[3], float normal[3])
{
    double length = sqrt(dot(parts, parts));
    for (int i = 0; i < 3; ++i) {
        const double along[3] = {a->axis[0][i], a->axis[1][i], a->axis[2][i]};
        normal[i] = (float)(dot(parts, along) / length) + 0.0f; // no -0
    }
}

// The face that the ray passes last.
static void set_face_normal(const approach *a, const duet_pose *box, int dims, float normal[3])
{
    double last = -INFINITY, parts[3] = {0};
    for (int k = 0; k < dims; ++k) {
        double side = a->go[k] > 0 ? -1 : 1;
        double in = (side * box->half_extents[k] - a->at[k]) / a->go[k];
        if (fabs(a->go[k]) <= SLOW * a->length || in <= last)
            continue;
        last = in;
        parts[0] = parts[1] = parts[2] = 0;
        parts[k] = side;
    }
    set_normal(a, parts, normal);
}

void ray_normal(const duet_ray *ray, const duet_pose *box, const double shift[3], uint32_t dims,
                float normal[3])
{
    duet_ray flat = flat_ray(ray, dims), start = start_of(ray);
    duet_pose pose = narrow_flat(box, dims);
    memset(normal, 0, 3 * sizeof *normal);
    if (ray_meets_apart(&start, box, shift, dims))
        return;
    approach a = approach_of(&flat, &pose, shift, (int)dims);
    set_face_normal(&a, &pose, (int)dims, normal);
}

// A gap is above 0, or below, exactly if the ray begins before the face.
void ray_normal_of_bounds(const duet_ray *ray, const duet_bounds *box, uint32_t dims,
                          float normal[3])
{
    double last = 0;
    memset(normal, 0, 3 * sizeof *normal);
    for (uint32_t k = 0; k < dims; ++k) {
        double speed = ray->direction[k];
        double gap = (double)(speed > 0 ? box->lower : box->upper)[k] - ray->origin[k];
        if (speed == 0 || gap / speed <= last)
            continue;
        last = gap / speed;
        memset(normal, 0, 3 * sizeof *normal);
        normal[k] = speed > 0 ? -1.0f : 1.0f;
    }
}

static bool begins_in_rounded(const duet_ray *ray, const approach *a, const duet_rounded_box *box,
                              uint32_t dims)
{
    double beyond[3], distance = sqrt(beyond_core(a, &box->pose, 0, beyond));
    double doubt = SLACK * (a->size + box->radius);
    duet_ray start = start_of(ray);
    float t = 0;
    if (fabs(distance - box->radius) > doubt && a->size > 0x1p-140)
        return distance < box->radius;
    return ray_meets_rounded(&start, box, dims, &t);
}

// Along the gap between the core and the place where the ray enters; where rounding is all that
// there is of it, the radius is so small that the core's face is the surface.
void ray_normal_of_rounded(const duet_ray *ray, const duet_rounded_box *box, uint32_t dims,
                           float normal[3])
{
    duet_ray flat = flat_ray(ray, dims);
    const duet_rounded_box round = {narrow_flat(&box->pose, dims), box->radius};
    approach a = approach_of(&flat, &round.pose, narrow_here, (int)dims);
    double beyond[3];
    memset(normal, 0, 3 * sizeof *normal);
    if (begins_in_rounded(ray, &a, &round, dims))
        return;
    double t = fmin(enter(&a, &round.pose, round.radius, 0), ray->t_max);
    if (sqrt(beyond_core(&a, &round.pose, t, beyond)) > SLACK * (a.size + round.radius))
        set_normal(&a, beyond, normal);
    else
        set_face_normal(&a, &round.pose, (int)dims, normal);
}
