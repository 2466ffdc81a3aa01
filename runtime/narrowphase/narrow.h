// SPDX-License-Identifier: MIT
// Whether two boxes share a point, decided on the host and never wrongly.
//
// The devices test pairs in float with a derived error bound; what the bound
// leaves open comes here: double with its own bound, then exact integers.
// Sets are closed: touching collides. docs/notes/accuracy.md derives the bounds.
//
// Every answer is the same for (a, b) and (b, a) and for q and -q.
#ifndef RUNTIME_NARROW_H
#define RUNTIME_NARROW_H

#include "runtime/duet.h"

typedef enum narrow_answer { NARROW_SEPARATED, NARROW_COLLIDING, NARROW_UNDECIDED } narrow_answer;

// The error of an axis's separation is below NARROW_SLACK * u * (|t|_1 + all extents),
// with u the unit of rounding: docs/notes/accuracy.md, line by line.
#define NARROW_SLACK 48

// 15 axes (equation 3; in 2D: 4) in double with the bound of docs/accuracy.md.
// Boxes along the world's axes, turned by quarters or not at all, are always
// decided, and poses that hold a NaN, an infinity or a zero quaternion never.
narrow_answer narrow_double(const duet_pose *a, const duet_pose *b, uint32_t dims);

// The exact answer by integer arithmetic, some microseconds. A pose that is no
// box (not finite, a negative extent, a zero quaternion) collides with nothing.
bool narrow_exact(const duet_pose *a, const duet_pose *b, uint32_t dims);

// narrow_double, then narrow_exact where that is undecided.
bool narrow_decide(const duet_pose *a, const duet_pose *b, uint32_t dims);

// The same where b lies `shift` further than its pose says, as between origin
// cells (runtime/narrowphase/origin.h): the difference of the poses' centres is then exact in
// float. narrow_here is no shift.
extern const double narrow_here[3];
bool narrow_decide_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                         uint32_t dims);
bool narrow_exact_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                        uint32_t dims);

// The greatest separation along the 15 (4) axes in double: above 0 it separates the
// boxes, up to its error of NARROW_SLACK * 2^-53 * (|t|_1 + all extents). An
// axis across two edges has the length of the sine between them.
double narrow_separation_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                               uint32_t dims);

// duet_poses_separation, likewise.
double narrow_widest_separation(const duet_pose *a, const duet_pose *b, const double shift[3],
                                uint32_t dims);

// Axis-aligned boxes by their corners: float comparisons are exact.
bool narrow_bounds(const duet_bounds *a, const duet_bounds *b, uint32_t dims);

// Finite, no negative extent, a rotation: the components that dims reads.
bool narrow_is_box(const duet_pose *pose, uint32_t dims);

// Whether the box lies along the world's axes, turned by quarters or not at all, and how far it
// reaches along them.
bool narrow_is_upright(const duet_pose *pose, double reach[3]);

// axis[i]: the direction of edge i. Returns |q|^2.
double narrow_axes(double axis[3][3], const float q[4]);

// A 2D pose as the 3D one that lies in the plane z = 0; a 3D pose as it is.
duet_pose narrow_flat(const duet_pose *pose, uint32_t dims);

#endif
