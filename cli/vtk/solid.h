// SPDX-License-Identifier: MIT
// The shape of a body as one cell of VTK: a box is a hexahedron, in 2D a quadrilateral, exactly. A
// body with a radius is a polyhedron, in 2D a polygon, whose points lie on its surface: so it is
// a little smaller than the body.
//
// All boxes are one solid, and so are all bodies whose cores have extents along the same axes:
// points say where they are by the body's half extents and radius.
#ifndef CLI_SOLID_H
#define CLI_SOLID_H

#include "runtime/duet.h"

#include <stdint.h>

// 6 faces, 12 rounded edges of 3 and 8 corners of 9 faces, with 24 + 12 * 2 * 2 + 8 points.
enum { SOLID_POINTS = 80, SOLID_FACES = 114, SOLID_WORDS = 5 * SOLID_FACES, SOLID_KINDS = 9 };

typedef struct solid_point {
    int8_t side[3]; // the core's corner, -1 or 1; 0: the core has no extent there
    double out[3];  // direction of the radius; 0: none
} solid_point;

typedef struct solid {
    uint8_t cell; // VTK's number of its kind
    uint32_t n_points;
    uint32_t n_faces; // a polyhedron has them
    uint32_t n_words;
    solid_point points[SOLID_POINTS];
    uint8_t words[SOLID_WORDS]; // each face: how many points, and which, seen from outside
} solid;

// All kinds in a world of dims.
void solids_make(solid solids[SOLID_KINDS], uint32_t dims);
uint32_t solid_kind(const duet_rounded_box *box, uint32_t dims);

// Places the solid's points on a body: at[n_points].
void solid_place(const solid *s, const duet_rounded_box *box, const duet_state *state,
                 double (*at)[3]);

#endif
