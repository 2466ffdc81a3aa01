// SPDX-License-Identifier: MIT
// A piece of a ground: what lies under a triangle of heights, without an end below, which three
// upright planes and the triangle's own bound; or a triangle of a mesh, a sheet, by itself.
#ifndef RUNTIME_GROUND_PIECE_H
#define RUNTIME_GROUND_PIECE_H

#include "runtime/narrowphase/ground_probe.h"

enum { PIECE_TOP = 3, PIECE_PLANES = 4 };

typedef struct ground_piece {
    double corner[3][3];       // counterclockwise, seen from above
    bool is_sheet;             // and has no rim
    bool is_rim[PIECE_PLANES]; // of the ground; the top is none
} ground_piece;

// Whether a probe meets it, touching included: in double with an error bound, then in rational
// numbers. Sets entry if it does.
bool ground_piece_meet(const ground_piece *p, const ground_probe *probe, ground_entry *entry);

// Either, as the probe has a radius or none, no later than the best so far. Sets that and returns
// true if it is sooner.
bool ground_piece_improve(const ground_piece *p, const ground_probe *probe, ground_entry *best);

// The square of a point's distance from the triangle.
double ground_piece_square(const ground_piece *p, const double at[3]);

// An axis that may separate a piece from a box: its direction is out of the piece, or in both
// directions if the piece is a sheet, or the axis level and none of the prism's own.
enum { PIECE_AXES = 19 }; // planes, the box's axes, products of edges, of axes across the upright

// Axes 7 to 15 are products of a box's axis and an edge of the triangle.
static inline bool piece_axis_is_product(int k, int *axis, int *edge)
{
    *axis = (k - 7) / 3;
    *edge = (k - 7) % 3;
    return k >= 7 && k < 16;
}

// By rational numbers alone; sets the time and the axis that separates last, -1 for none.
bool ground_piece_meet_exactly(const ground_piece *p, const ground_probe *probe, double *t,
                               int *entered);

#endif
