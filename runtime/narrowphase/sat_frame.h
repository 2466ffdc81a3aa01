// SPDX-License-Identifier: MIT
// Two boxes seen from each other, in float, operation for operation as the
// devices compute it (kernels/narrowphase/object.clh, kernels/narrowphase/sat.clh).
//
// Products reach a sum only through fma and nothing is divided, so that every
// device that rounds as IEEE asks has the same bits. Sound boxes only.
#ifndef RUNTIME_SAT_FRAME_H
#define RUNTIME_SAT_FRAME_H

#include "runtime/duet.h"

typedef struct sat_frame {
    int dims;
    float a[3], b[3];   // half extents
    float ta[3], tb[3]; // the way from a to b along a's edges and along b's
    float c[3][3];      // 3D: cosines between edge i of a and edge j of b
    float size_c[3][3]; // without their signs
    float size;         // |t|_1 and all extents
    bool trusted;       // size is where the bound of docs/accuracy.md holds
} sat_frame;

// b lies `shift` further than its pose says, as in runtime/narrowphase/narrow.h.
sat_frame sat_frame_of(const duet_pose *a, const duet_pose *b, const double shift[3],
                       uint32_t dims);

// The greatest separation along the faces' axes, and the separation along the product of
// edge i of a and edge j of b.
float sat_frame_face_separation(const sat_frame *m);
float sat_frame_edge_separation(const sat_frame *m, int i, int j);

// Bounds that contain the box. rotated false takes its rotation for the identity.
duet_bounds sat_bounds(const duet_pose *pose, uint32_t dims, bool rotated);

duet_bounds sat_rounded_bounds(const duet_rounded_box *box, uint32_t dims, bool rotated);

// Whether bounds overlap of which b's count from `shift` further on.
bool sat_bounds_overlap(const duet_bounds *a, const duet_bounds *b, const double shift[3],
                        uint32_t dims);

// Whether the bounding spheres may share a point; they are rounded outward.
bool sat_spheres_overlap(const duet_pose *a, const duet_pose *b, const double shift[3],
                         uint32_t dims);
bool sat_rounded_spheres_overlap(const duet_rounded_box *a, const duet_rounded_box *b,
                                 uint32_t dims);

#endif
