// SPDX-License-Identifier: MIT
// Whether two boxes share a point, decided on the host and never wrongly.
//
// The devices test pairs in float with a derived error bound; what the bound
// leaves open comes here: double with its own bound, then exact rationals.
// Sets are closed: touching collides.
#ifndef RUNTIME_NARROW_H
#define RUNTIME_NARROW_H

#include "runtime/duet.h"

typedef enum narrow_verdict { NARROW_SEPARATED, NARROW_COLLIDING, NARROW_UNDECIDED } narrow_verdict;

// 15 axes (equation 3; in 2D: 4) in double with the bound of docs/accuracy.md.
narrow_verdict narrow_double(const duet_pose *a, const duet_pose *b, uint32_t dims);

// The exact answer by rational arithmetic. Slow; never undecided.
bool narrow_exact(const duet_pose *a, const duet_pose *b, uint32_t dims);

// narrow_double, then narrow_exact where that is undecided.
bool narrow_decide(const duet_pose *a, const duet_pose *b, uint32_t dims);

// Axis-aligned boxes by their corners: float comparisons are exact.
bool narrow_bounds(const duet_bounds *a, const duet_bounds *b, uint32_t dims);

#endif
