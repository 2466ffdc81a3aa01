// SPDX-License-Identifier: MIT
// Trees on the tests' devices, and what is asked of them.
#ifndef TESTS_TREES_H
#define TESTS_TREES_H

#include "runtime/duet.h"

duet_tree *open_tree(uint32_t dims, uint32_t share, const duet_pose *poses, uint32_t n);
duet_tree *open_bounds_tree(uint32_t dims, uint32_t share, const duet_bounds *bounds, uint32_t n);
// Of rounded boxes or spheres.
duet_tree *open_rounded_tree(uint32_t dims, uint32_t share, duet_object_kind kind,
                             const void *objects, uint32_t n);
void set_poses(duet_tree *tree, const duet_pose *poses, uint32_t n);

duet_sweep_query *open_sweep_query(duet_tree *tree, duet_query_wants wants);
// Valid until the query's next run.
duet_sweep_query_result run_sweeps(duet_sweep_query *query, duet_object_kind kind,
                                   const void *sweeps, uint64_t n);

#endif
