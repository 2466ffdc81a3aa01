// SPDX-License-Identifier: MIT
// The specification in C of what devices decide in float, for tests to compare with.
#ifndef SUPPORT_NARROW_FLOAT_H
#define SUPPORT_NARROW_FLOAT_H

#include "runtime/narrowphase/narrow.h"

// Computes what the devices compute in float, operation for operation
// (kernels/narrowphase/sat.clh), with its bound. rotated false takes both rotations for the
// identity; it is then undecided only where a distance is above 2^100.
narrow_answer narrow_float(const duet_pose *a, const duet_pose *b, uint32_t dims, bool rotated);

// The same where b lies `shift` further than its pose says.
narrow_answer narrow_float_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                                 uint32_t dims, bool rotated);

#endif
