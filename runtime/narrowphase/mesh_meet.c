// SPDX-License-Identifier: MIT
// The triangles near a way, or near a point: the nearer half of what lies under a node first. What
// is later, or further away, than what was found is left out.
#include "runtime/narrowphase/mesh_meet.h"

#include "runtime/narrowphase/ground_piece.h"
#include "runtime/narrowphase/mesh.h"

#include <math.h>

static ground_piece piece_of(const duet_mesh *mesh, uint32_t triangle)
{
    ground_piece p = {.is_sheet = true};
    for (uint32_t k = 0; k < 3; ++k)
        mesh_place(mesh, triangle, k, p.corner[k]);
    return p;
}

// ---------------------------------------------------------------- a way

typedef struct walk {
    const duet_mesh *mesh;
    const mesh_node *tree;
    const ground_probe *probe;
    ground_entry best; // t is infinite before there is one
} walk;

// Cuts the times to those at which a probe is between a node's bounds along an axis. Quotients and
// bounds are right within 2^-50.
static void cut_to_bounds(const walk *w, const mesh_node *node, int k, double *from, double *to)
{
    double centre = w->probe->centre[k], go = w->probe->direction[k];
    double lower = w->mesh->origin[k] + (double)node->bounds[k] - centre;
    double upper = w->mesh->origin[k] + (double)node->bounds[3 + k] - centre;
    double wide = w->probe->reach[k] +
                  0x1p-38 * (fabs(centre) + fabs(lower) + fabs(upper) + w->probe->reach[k]);
    lower -= wide;
    upper += wide;
    if (go == 0.0) {
        *from = lower <= 0.0 && upper >= 0.0 ? *from : INFINITY;
        return;
    }
    *from = fmax(*from, fmin(lower / go, upper / go));
    *to = fmin(*to, fmax(lower / go, upper / go));
}

// When the probe first meets the bounds of a node, or a little before; infinite: it never does.
static double time_of(const walk *w, uint32_t node)
{
    double from = 0.0, to = w->probe->t_max;
    for (int k = 0; k < 3; ++k)
        cut_to_bounds(w, &w->tree[node], k, &from, &to);
    return from <= to ? from : INFINITY;
}

// An infinite time is no sooner than the best.
static bool is_sooner(const walk *w, double time)
{
    return time <= w->best.t && time < INFINITY && w->best.t > 0.0;
}

static void meet_node(walk *w, uint32_t node, double time)
{
    if (!is_sooner(w, time))
        return;
    if (w->tree[node].triangle != MESH_NO_TRIANGLE) {
        const ground_piece p = piece_of(w->mesh, w->tree[node].triangle);
        ground_piece_improve(&p, w->probe, &w->best);
        return;
    }
    uint32_t one = node + 1, two = w->tree[one].skip;
    double at_one = time_of(w, one), at_two = time_of(w, two);
    bool swap = at_two < at_one;
    meet_node(w, swap ? two : one, swap ? at_two : at_one);
    meet_node(w, swap ? one : two, swap ? at_one : at_two);
}

bool mesh_meet(const duet_mesh *mesh, const mesh_node *tree, const ground_probe *probe,
               ground_entry *entry)
{
    walk w = {.mesh = mesh, .tree = tree, .probe = probe, .best = {.t = INFINITY}};
    meet_node(&w, 0, time_of(&w, 0));
    *entry = w.best;
    return w.best.t < INFINITY;
}

// ---------------------------------------------------------------- a point

typedef struct search {
    const duet_mesh *mesh;
    const mesh_node *tree;
    double at[3];
    double square; // of the least distance so far
} search;

// The square of the distance to a node's bounds, or a little less.
static double square_of(const search *s, uint32_t node)
{
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
        double lower = s->mesh->origin[k] + (double)s->tree[node].bounds[k];
        double upper = s->mesh->origin[k] + (double)s->tree[node].bounds[3 + k];
        double gap = fmax(0.0, fmax(lower - s->at[k], s->at[k] - upper));
        square += gap * gap;
    }
    return square * (1.0 - 0x1p-40);
}

static void search_node(search *s, uint32_t node, double square)
{
    if (square > s->square)
        return;
    if (s->tree[node].triangle != MESH_NO_TRIANGLE) {
        const ground_piece p = piece_of(s->mesh, s->tree[node].triangle);
        s->square = fmin(s->square, ground_piece_square(&p, s->at));
        return;
    }
    uint32_t one = node + 1, two = s->tree[one].skip;
    double to_one = square_of(s, one), to_two = square_of(s, two);
    bool swap = to_two < to_one;
    search_node(s, swap ? two : one, swap ? to_two : to_one);
    search_node(s, swap ? one : two, swap ? to_one : to_two);
}

double mesh_distance(const duet_mesh *mesh, const mesh_node *tree, const float at[3])
{
    search s = {.mesh = mesh, .tree = tree, .at = {at[0], at[1], at[2]}, .square = INFINITY};
    search_node(&s, 0, 0.0);
    return sqrt(s.square);
}
