// SPDX-License-Identifier: MIT
// Whether a moving box meets a prism, in double with an error bound.
//
// At each time no axis of 19 separates two that meet (a point: of 4). Along an axis the box comes
// nearer at a constant speed: each axis cuts the times, and what is left is when they meet.
#include "runtime/narrowphase/heights_prism.h"

#include "runtime/narrowphase/vector.h"

#include <math.h>

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

#define SLACK (64 * 0x1p-53) // of sums of products of what is itself rounded a few times

typedef enum met { MISSED, MET, OPEN } met;

// Each number of a normal is known within SLACK times the sum of amounts that it is made of.
typedef struct plane {
    double normal[3], amounts[3];
} plane;

static void set_product(plane *s, const double u[3], const double sums[3], const double v[3])
{
    cross(s->normal, u, v);
    for (int i = 0; i < 3; ++i) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        s->amounts[i] = sums[a] * fabs(v[b]) + sums[b] * fabs(v[a]);
    }
}

static void set_level(plane *s, const double along[3], const double sums[3])
{
    *s = (plane){{along[1], -along[0]}, {sums[1], sums[0]}};
}

static plane plane_of(const heights_prism *p, const heights_probe *probe, int k)
{
    plane s = {0};
    double e[3][3], sums[3];
    int axis, edge;
    for (int i = 0; i < 9; ++i)
        e[i / 3][i % 3] = p->corner[(i / 3 + 1) % 3][i % 3] - p->corner[i / 3][i % 3];
    if (prism_axis_is_product(k, &axis, &edge)) {
        set_product(&s, probe->axis[axis], probe->sums[axis], e[edge]);
        return s;
    }
    for (int i = 0; i < 3; ++i)
        sums[i] = fabs(e[k % 3][i]);
    if (k < PRISM_TOP)
        set_level(&s, e[k], sums);
    else if (k == PRISM_TOP)
        set_product(&s, e[0], sums, e[1]);
    else if (k >= 16)
        set_level(&s, probe->axis[k - 16], probe->sums[k - 16]);
    for (int i = 0; k > PRISM_TOP && k < 7 && i < 3; ++i) {
        s.normal[i] = probe->axis[k - PRISM_PLANES][i];
        s.amounts[i] = probe->sums[k - PRISM_PLANES][i];
    }
    return s;
}

// How far a box reaches into the prism along a normal: at + t speed, each known within an error.
typedef struct within {
    double at, at_error, speed, speed_error;
} within;

static void add_box(within *w, const plane *s, const heights_probe *probe)
{
    for (int k = 0; k < 3; ++k) {
        double along = 0.0, sum = 0.0;
        for (int i = 0; i < 3; ++i) {
            along += probe->axis[k][i] * s->normal[i];
            sum += probe->sums[k][i] * s->amounts[i];
        }
        w->at += probe->half[k] * fabs(along);
        w->at_error += SLACK * probe->half[k] * sum;
    }
}

static within within_of(const heights_prism *p, const plane *s, const heights_probe *probe)
{
    within w = {.at = -INFINITY};
    for (int corner = 0; corner < 3; ++corner) {
        double at = 0.0, sum = 0.0;
        for (int i = 0; i < 3; ++i) {
            double way = p->corner[corner][i] - probe->centre[i];
            at += s->normal[i] * way;
            sum += s->amounts[i] * (fabs(way) + probe->inexact * fabs(probe->centre[i]));
        }
        w.at = fmax(w.at, at);
        w.at_error = fmax(w.at_error, SLACK * sum);
    }
    for (int i = 0; i < 3; ++i) {
        w.speed -= s->normal[i] * probe->direction[i];
        w.speed_error += SLACK * s->amounts[i] * fabs((double)probe->direction[i]);
    }
    if (!probe->is_point)
        add_box(&w, s, probe);
    return w;
}

// The times at which none of the axes so far separates, as far as they are sure.
typedef struct span {
    double surely_enter, maybe_enter, surely_leave, maybe_leave;
    int entered; // axis that separates last; -1: none
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

static void negate(plane *s)
{
    for (int i = 0; i < 3; ++i)
        s->normal[i] = -s->normal[i];
}

// As cut_by_axis of heights_exact.c. An axis of which nobody knows whether it points down cuts
// nothing.
static void cut_by_axis(span *s, const heights_prism *p, const heights_probe *probe, int k)
{
    plane side = plane_of(p, probe, k);
    double up = k == PRISM_TOP ? 1.0 : side.normal[2], doubt = SLACK * side.amounts[2];
    if (k > PRISM_TOP && doubt > 0.0 && fabs(up) <= doubt) {
        s->so_far = s->so_far == MISSED ? MISSED : OPEN;
        return;
    }
    if (up < 0.0)
        negate(&side);
    within w = within_of(p, &side, probe);
    cut(s, &w, k);
    if (up != 0.0 || k < PRISM_TOP)
        return;
    negate(&side);
    w = within_of(p, &side, probe);
    cut(s, &w, k);
}

static met meet_in_double(const heights_prism *p, const heights_probe *probe, double *t,
                          int *entered)
{
    span s = {
        .surely_leave = probe->t_max, .maybe_leave = probe->t_max, .entered = -1, .so_far = MET};
    int n = probe->is_point ? PRISM_PLANES : PRISM_AXES;
    for (int k = 0; k < n && s.so_far != MISSED && s.maybe_enter <= s.maybe_leave; ++k)
        cut_by_axis(&s, p, probe, k);
    *t = fmax(0.0, 0.5 * (s.surely_enter + s.maybe_enter));
    *entered = s.entered;
    if (s.so_far == MISSED || s.maybe_enter > s.maybe_leave)
        return MISSED;
    bool begins = s.surely_enter == 0.0 || s.maybe_enter > 0.0; // there, or surely later
    return s.so_far == MET && begins && s.surely_enter <= s.surely_leave ? MET : OPEN;
}

// ---------------------------------------------------------------- both

// What is entered by a level axis inside the ground is entered by its edge at the top.
static void set_normal(const heights_prism *p, const heights_probe *probe, int entered,
                       double normal[3])
{
    bool is_rim = p->is_rim[0] || p->is_rim[1] || p->is_rim[2];
    bool is_inner =
        entered < 0 || (entered < PRISM_TOP && !p->is_rim[entered]) || (entered >= 16 && !is_rim);
    plane s = plane_of(p, probe, is_inner ? PRISM_TOP : entered);
    if (s.normal[2] < 0.0 ||
        (entered >= PRISM_PLANES && s.normal[2] == 0.0 &&
         dot(s.normal, (const double[3]){probe->direction[0], probe->direction[1], 0.0}) > 0.0))
        negate(&s);
    for (int i = 0; i < 3; ++i)
        normal[i] = s.normal[i];
}

bool heights_prism_meet(const heights_prism *p, const heights_probe *probe, heights_entry *entry)
{
    int entered;
    met found = meet_in_double(p, probe, &entry->t, &entered);
    if (found == MISSED ||
        (found == OPEN && !heights_prism_meet_exactly(p, probe, &entry->t, &entered)))
        return false;
    set_normal(p, probe, entered, entry->normal);
    return true;
}
