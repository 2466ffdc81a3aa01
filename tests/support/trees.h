// SPDX-License-Identifier: MIT
// Trees on the tests' devices.
#ifndef TESTS_TREES_H
#define TESTS_TREES_H

#include "runtime/duet.h"

duet_tree *open_tree(uint32_t dims, uint32_t share, const duet_pose *poses, uint32_t n);
duet_tree *open_bounds_tree(uint32_t dims, uint32_t share, const duet_bounds *bounds, uint32_t n);
void set_poses(duet_tree *tree, const duet_pose *poses, uint32_t n);

#endif
