// SPDX-License-Identifier: MIT
// Whether a moving box meets a piece of a ground, in double with an error bound.
//
// At each time no axis of 19 separates two that meet (a point: of 4). Along an axis the box comes
// nearer at a constant speed: each axis cuts the times, and what is left is when they meet.
#include "runtime/narrowphase/ground_piece.h"

#include "runtime/narrowphase/vector.h"

#include <math.h>

#define SLACK (64 * 0x1p-53) // of sums of products of what is itself rounded a few times

typedef enum met { MISSED, MET, OPEN } met;

// Each number of a normal is known within SLACK times the sum of amounts that it is made of.
typedef struct plane {
    double normal[3], amounts[3];
} plane;

static void set_product(plane *s, const double u[3], const double u_sums[3], const double v[3],
                        const double v_sums[3])
{
    cross(s->normal, u, v);
    for (int i = 0; i < 3; ++i) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        s->amounts[i] = u_sums[a] * v_sums[b] + u_sums[b] * v_sums[a];
    }
}

static void set_edges(const ground_piece *p, double e[3][3], double sums[3][3])
{
    for (int i = 0; i < 9; ++i) {
        e[i / 3][i % 3] = p->corner[(i / 3 + 1) % 3][i % 3] - p->corner[i / 3][i % 3];
        sums[i / 3][i % 3] = fabs(e[i / 3][i % 3]);
    }
}

// The direction that lies in all planes but the top: a prism's is upright.
static plane upright_of(const ground_piece *p, const plane *top)
{
    return p->is_sheet ? *top : (plane){{0, 0, 1}, {0, 0, 1}};
}

static plane plane_of(const ground_piece *p, const ground_probe *probe, int k)
{
    plane s = {0};
    double e[3][3], sums[3][3];
    int axis, edge;
    set_edges(p, e, sums);
    if (piece_axis_is_product(k, &axis, &edge)) {
        set_product(&s, probe->axis[axis], probe->sums[axis], e[edge], sums[edge]);
        return s;
    }
    for (int i = 0; k > PIECE_TOP && k < 7 && i < 3; ++i) {
        s.normal[i] = probe->axis[k - PIECE_PLANES][i];
        s.amounts[i] = probe->sums[k - PIECE_PLANES][i];
    }
    if (k > PIECE_TOP && k < 7)
        return s;
    set_product(&s, e[0], sums[0], e[1], sums[1]);
    const plane up = upright_of(p, &s);
    if (k < PIECE_TOP)
        set_product(&s, e[k], sums[k], up.normal, up.amounts);
    else if (k >= 16)
        set_product(&s, probe->axis[k - 16], probe->sums[k - 16], up.normal, up.amounts);
    return s;
}

// How far a box reaches into the piece along a normal: at + t speed, each known within an error.
typedef struct within {
    double at, at_error, speed, speed_error;
} within;

static void add_box(within *w, const plane *s, const ground_probe *probe)
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

static within within_of(const ground_piece *p, const plane *s, const ground_probe *probe)
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

static void cut_along(span *s, const ground_piece *p, const ground_probe *probe, int k,
                      const plane *side)
{
    const within w = within_of(p, side, probe);
    cut(s, &w, k);
}

// Does as cut_by_axis of ground_exact.c. An axis of which nobody knows whether it points down cuts
// nothing of a prism.
static void cut_by_axis(span *s, const ground_piece *p, const ground_probe *probe, int k)
{
    plane side = plane_of(p, probe, k);
    double up = k == PIECE_TOP ? 1.0 : side.normal[2], doubt = SLACK * side.amounts[2];
    if (!p->is_sheet && k > PIECE_TOP && doubt > 0.0 && fabs(up) <= doubt) {
        s->so_far = s->so_far == MISSED ? MISSED : OPEN;
        return;
    }
    if (!p->is_sheet && up < 0.0)
        negate(&side);
    cut_along(s, p, probe, k, &side);
    if (!p->is_sheet && (up != 0.0 || k < PIECE_TOP))
        return;
    negate(&side);
    cut_along(s, p, probe, k, &side);
}

// A point is in a sheet's plane at one time, which must be one of those that the edges leave.
static void pass_through(span *s, const ground_piece *p, const ground_probe *probe)
{
    const plane top = plane_of(p, probe, PIECE_TOP);
    const within w = within_of(p, &top, probe);
    span at = {.surely_leave = INFINITY, .maybe_leave = INFINITY, .maybe_enter = -INFINITY};
    if (fabs(w.speed) <= w.speed_error) {
        cut_by_axis(s, p, probe, PIECE_TOP);
        return;
    }
    cut_by_axis(&at, p, probe, PIECE_TOP);
    double first = at.surely_leave, last = at.maybe_leave; // between them
    if (last < s->maybe_enter || first > s->maybe_leave)
        s->so_far = MISSED;
    else if (s->so_far == MET && (first < s->surely_enter || last > s->surely_leave))
        s->so_far = OPEN;
    s->entered = PIECE_TOP;
    s->maybe_enter = first;
    s->surely_enter = s->surely_leave = s->maybe_leave = last;
}

static met meet_in_double(const ground_piece *p, const ground_probe *probe, double *t, int *entered)
{
    span s = {
        .surely_leave = probe->t_max, .maybe_leave = probe->t_max, .entered = -1, .so_far = MET};
    bool passes = probe->is_point && p->is_sheet;
    int n = passes ? PIECE_TOP : probe->is_point ? PIECE_PLANES : PIECE_AXES;
    for (int k = 0; k < n && s.so_far != MISSED && s.maybe_enter <= s.maybe_leave; ++k)
        cut_by_axis(&s, p, probe, k);
    if (passes && s.so_far != MISSED && s.maybe_enter <= s.maybe_leave)
        pass_through(&s, p, probe);
    *t = fmax(0.0, 0.5 * (s.surely_enter + s.maybe_enter));
    *entered = s.entered;
    if (s.so_far == MISSED || s.maybe_enter > s.maybe_leave)
        return MISSED;
    bool begins = s.surely_enter == 0.0 || s.maybe_enter > 0.0; // there, or surely later
    return s.so_far == MET && begins && s.surely_enter <= s.surely_leave ? MET : OPEN;
}

// ---------------------------------------------------------------- both

// The plane by which a prism is entered: by a level axis inside the ground, its edge at the top.
static int plane_entered(const ground_piece *p, int entered)
{
    bool is_rim = p->is_rim[0] || p->is_rim[1] || p->is_rim[2];
    bool is_inner =
        entered < 0 || (entered < PIECE_TOP && !p->is_rim[entered]) || (entered >= 16 && !is_rim);
    return is_inner ? PIECE_TOP : entered;
}

static void turn_out_of_prism(plane *s, const ground_probe *probe, int entered)
{
    if (s->normal[2] < 0.0 ||
        (entered >= PIECE_PLANES && s->normal[2] == 0.0 &&
         dot(s->normal, (const double[3]){probe->direction[0], probe->direction[1], 0.0}) > 0.0))
        negate(s);
}

// A point that is not in a sheet's plane all along enters the sheet by it.
static int sheet_entered(const ground_piece *p, const ground_probe *probe, int entered)
{
    const plane top = plane_of(p, probe, PIECE_TOP);
    const within w = within_of(p, &top, probe);
    return entered < 0 || (probe->is_point && fabs(w.speed) > w.speed_error) ? PIECE_TOP : entered;
}

static void turn_to_probe(plane *s, const ground_probe *probe)
{
    const float *d = probe->direction;
    if (dot(s->normal, (const double[3]){d[0], d[1], d[2]}) > 0.0)
        negate(s);
}

static void set_normal(const ground_piece *p, const ground_probe *probe, int entered,
                       double normal[3])
{
    int by = p->is_sheet ? sheet_entered(p, probe, entered) : plane_entered(p, entered);
    plane s = plane_of(p, probe, by);
    if (p->is_sheet)
        turn_to_probe(&s, probe);
    else
        turn_out_of_prism(&s, probe, entered);
    for (int i = 0; i < 3; ++i)
        normal[i] = s.normal[i];
}

bool ground_piece_meet(const ground_piece *p, const ground_probe *probe, ground_entry *entry)
{
    int entered;
    met found = meet_in_double(p, probe, &entry->t, &entered);
    if (found == MISSED ||
        (found == OPEN && !ground_piece_meet_exactly(p, probe, &entry->t, &entered)))
        return false;
    set_normal(p, probe, entered, entry->normal);
    return true;
}
