// SPDX-License-Identifier: MIT
// A level of accuracy on the host, operation for operation as on the devices,
// so that what a device finds at a level can be compared bit by bit.
#ifndef RUNTIME_LEVEL_H
#define RUNTIME_LEVEL_H

#include "runtime/duet.h"

// Whether the level takes the two for colliding, b lying `shift` further than its
// pose says (runtime/narrowphase/narrow.h). rotated false: both rotations are the identity, and
// all levels but aabb and sphere are exact.
bool level_collide(duet_level level, const duet_pose *a, const duet_pose *b, const double shift[3],
                   uint32_t dims, bool rotated);

// The same of boxes that have a radius: all levels but aabb and sphere are exact.
bool level_collide_rounded(duet_level level, const duet_rounded_box *a, const duet_rounded_box *b,
                           uint32_t dims, bool rotated);

// Whether the level differs from certified where nothing is rotated.
bool level_tests_upright(duet_level level);

#endif
