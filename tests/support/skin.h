// SPDX-License-Identifier: MIT
// Objects that bounce between walls, with a grid that lasts until one leaves its
// skin, against the same without a skin and against each pair tested.
#ifndef TESTS_SKIN_H
#define TESTS_SKIN_H

#include "support/mover.h"

// Fails where a step misses a contact of two boxes that overlap by two slops, or where
// the skin changes a bit of the state. The grid must have lasted now and then.
void skin_run(uint32_t steps);

// Fails where boxes that overlap by two slops in poses [n], other than two without mass,
// are not among the contacts of the last step.
void skin_assert_none_missed(mover *m, const duet_pose *poses);

#endif
