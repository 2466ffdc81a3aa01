// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/heights_prism.h"

#include "runtime/narrowphase/vector.h"

#include <gmp.h>
#include <math.h>
#include <string.h>

//   c --- d     a b d is the lower triangle of a cell, a d c the upper one
//   |   / |
//   | /   |
//   a --- b
heights_prism heights_prism_of(const duet_heights *h, uint32_t i, uint32_t j, bool upper)
{
    heights_prism p = {.is_rim = {!upper && j == 0, upper ? j + 2 == h->ny : i + 2 == h->nx,
                                  upper && i == 0, false}};
    heights_place(h, i, j, p.corner[0]);
    heights_place(h, i + 1, upper ? j + 1 : j, p.corner[1]);
    heights_place(h, upper ? i : i + 1, j + 1, p.corner[2]);
    return p;
}

// ---------------------------------------------------------------- double

#define SLACK (16 * 0x1p-53) // of a sum of three products, each of four rounded differences

typedef enum met { MISSED, MET, OPEN } met;

// A plane, with the sums of amounts that its normal is made of.
typedef struct plane {
    double normal[3], amounts[3]; // inward
    const double *through;
} plane;

static plane plane_of(const heights_prism *p, int k)
{
    plane s = {.through = p->corner[k % 3]};
    double e[2][3];
    for (int i = 0; i < 3; ++i) {
        e[0][i] = p->corner[(k + 1) % 3][i] - s.through[i];
        e[1][i] = p->corner[(k + 2) % 3][i] - s.through[i];
    }
    if (k < PRISM_TOP) {
        s.normal[0] = -e[0][1];
        s.normal[1] = e[0][0];
    } else {
        cross(s.normal, e[1], e[0]);
    }
    for (int i = 0; i < 3; ++i) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        s.amounts[i] =
            k < PRISM_TOP ? fabs(s.normal[i]) : fabs(e[1][a] * e[0][b]) + fabs(e[1][b] * e[0][a]);
    }
    return s;
}

// How far a ray is within a plane: at + t speed, each known within an error.
typedef struct within {
    double at, at_error, speed, speed_error;
} within;

static within within_of(const plane *s, const duet_ray *ray)
{
    within w = {0};
    for (int i = 0; i < 3; ++i) {
        double from = ray->origin[i] - s->through[i], go = ray->direction[i];
        w.at += s->normal[i] * from;
        w.at_error += SLACK * s->amounts[i] * fabs(from);
        w.speed += s->normal[i] * go;
        w.speed_error += SLACK * s->amounts[i] * fabs(go);
    }
    return w;
}

// The times at which a ray is in the prism, as far as they are sure.
typedef struct span {
    double surely_enter, maybe_enter, surely_leave, maybe_leave;
    int entered; // plane that is passed last; -1: none
    met so_far;
} span;

static void cut(span *s, const within *w, int k)
{
    if (fabs(w->speed) <= w->speed_error) {
        bool stays = w->speed_error == 0.0;
        if (stays && w->at < -w->at_error)
            s->so_far = MISSED;
        else if (s->so_far != MISSED && (!stays || w->at < w->at_error))
            s->so_far = OPEN;
        return;
    }
    double t = -w->at / w->speed, speed = fabs(w->speed);
    double doubt =
        (w->at_error + fabs(t) * w->speed_error) / (speed - w->speed_error) + fabs(t) * 0x1p-50;
    if (w->speed < 0.0) {
        s->surely_leave = fmin(s->surely_leave, t - doubt);
        s->maybe_leave = fmin(s->maybe_leave, t + doubt);
        return;
    }
    s->entered = t - doubt > s->maybe_enter ? k : s->entered;
    s->surely_enter = fmax(s->surely_enter, t + doubt);
    s->maybe_enter = fmax(s->maybe_enter, t - doubt);
}

static bool is_still(const duet_ray *ray)
{
    return ray->direction[0] == 0.0f && ray->direction[1] == 0.0f && ray->direction[2] == 0.0f;
}

static met meet_in_double(const heights_prism *p, const duet_ray *ray, double *t, int *entered)
{
    double end = is_still(ray) ? 0.0 : ray->t_max;
    span s = {.surely_leave = end, .maybe_leave = end, .entered = -1, .so_far = MET};
    for (int k = 0; k < PRISM_PLANES; ++k) {
        const plane side = plane_of(p, k);
        const within w = within_of(&side, ray);
        cut(&s, &w, k);
    }
    *t = fmax(0.0, 0.5 * (s.surely_enter + s.maybe_enter));
    *entered = s.entered;
    if (s.so_far == MISSED || s.maybe_enter > s.maybe_leave)
        return MISSED;
    return s.so_far == MET && s.surely_enter <= s.surely_leave ? MET : OPEN;
}

// ---------------------------------------------------------------- rational numbers

typedef struct numbers {
    mpq_t e[2][3], normal[3], way, at, speed, enter, leave, term;
} numbers;

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

static void set_difference(numbers *n, mpq_t out, double a, double b)
{
    mpq_set_d(out, a);
    mpq_set_d(n->term, b);
    mpq_sub(out, out, n->term);
}

static void set_plane(numbers *n, const heights_prism *p, int k)
{
    const double *through = p->corner[k % 3];
    for (int i = 0; i < 3; ++i) {
        set_difference(n, n->e[0][i], p->corner[(k + 1) % 3][i], through[i]);
        set_difference(n, n->e[1][i], p->corner[(k + 2) % 3][i], through[i]);
    }
    for (int i = 0; k == PRISM_TOP && i < 3; ++i) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        mpq_mul(n->normal[i], n->e[1][a], n->e[0][b]);
        mpq_mul(n->term, n->e[1][b], n->e[0][a]);
        mpq_sub(n->normal[i], n->normal[i], n->term);
    }
    if (k == PRISM_TOP)
        return;
    mpq_neg(n->normal[0], n->e[0][1]);
    mpq_set(n->normal[1], n->e[0][0]);
    mpq_set_ui(n->normal[2], 0, 1);
}

static void set_within(numbers *n, const heights_prism *p, const duet_ray *ray, int k)
{
    set_plane(n, p, k);
    mpq_set_ui(n->at, 0, 1);
    mpq_set_ui(n->speed, 0, 1);
    for (int i = 0; i < 3; ++i) {
        set_difference(n, n->way, ray->origin[i], p->corner[k % 3][i]);
        mpq_mul(n->way, n->way, n->normal[i]);
        mpq_add(n->at, n->at, n->way);
        mpq_set_d(n->way, ray->direction[i]);
        mpq_mul(n->way, n->way, n->normal[i]);
        mpq_add(n->speed, n->speed, n->way);
    }
}

// Whether some of the way is left.
static bool cut_exactly(numbers *n, bool *ends, int *entered, int k)
{
    int speed = mpq_sgn(n->speed);
    if (speed == 0)
        return mpq_sgn(n->at) >= 0;
    mpq_div(n->way, n->at, n->speed);
    mpq_neg(n->way, n->way);
    if (speed > 0 && mpq_cmp(n->way, n->enter) > 0) {
        mpq_set(n->enter, n->way);
        *entered = k;
    } else if (speed < 0 && (!*ends || mpq_cmp(n->way, n->leave) < 0)) {
        mpq_set(n->leave, n->way);
        *ends = true;
    }
    return !*ends || mpq_cmp(n->enter, n->leave) <= 0;
}

static bool meet_exactly(const heights_prism *p, const duet_ray *ray, double *t, int *entered)
{
    bool ends = isfinite(ray->t_max) || is_still(ray), meets = true;
    numbers n;
    open_numbers(&n);
    *entered = -1;
    if (ends)
        mpq_set_d(n.leave, is_still(ray) ? 0.0 : (double)ray->t_max);
    for (int k = 0; meets && k < PRISM_PLANES; ++k) {
        set_within(&n, p, ray, k);
        meets = cut_exactly(&n, &ends, entered, k);
    }
    *t = mpq_get_d(n.enter);
    close_numbers(&n);
    return meets;
}

// ---------------------------------------------------------------- both

// What is entered by an upright plane inside the ground is entered by its edge at the top.
static void set_normal(const heights_prism *p, int entered, double normal[3])
{
    bool is_wall = entered >= 0 && p->is_rim[entered];
    const plane s = plane_of(p, is_wall ? entered : PRISM_TOP);
    for (int i = 0; i < 3; ++i)
        normal[i] = -s.normal[i];
}

bool heights_prism_meet(const heights_prism *p, const duet_ray *ray, heights_entry *entry)
{
    int entered;
    met found = meet_in_double(p, ray, &entry->t, &entered);
    if (found == MISSED || (found == OPEN && !meet_exactly(p, ray, &entry->t, &entered)))
        return false;
    set_normal(p, entered, entry->normal);
    return true;
}
