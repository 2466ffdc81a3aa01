// SPDX-License-Identifier: MIT
// Trees and queries on the tests' devices, which last until a test ends, and what is asked of them.
#ifndef TESTS_TREES_H
#define TESTS_TREES_H

#include "base/rng.h"
#include "runtime/duet.h"

duet_tree *open_tree(uint32_t dims, uint32_t share, const duet_pose *poses, uint32_t n);
duet_tree *open_bounds_tree(uint32_t dims, uint32_t share, const duet_bounds *bounds, uint32_t n);
// Takes rounded boxes or spheres.
duet_tree *open_rounded_tree(uint32_t dims, uint32_t share, duet_object_kind kind,
                             const void *objects, uint32_t n);
// Draws boxes, capsules and spheres; some upright on round numbers, some without a radius, or with
// one that is too small for float to see.
duet_rounded_box draw_rounded(rng *r, uint32_t i);
void set_poses(duet_tree *tree, const duet_pose *poses, uint32_t n);

// Queries, and what they answer, valid until the query's next run.
duet_ray_query *open_ray_query(duet_tree *tree, duet_query_wants wants, bool normals);
duet_ray_query_result cast_rays(duet_ray_query *query, const duet_ray *rays, uint64_t n);
duet_point_query *open_point_query(duet_tree *tree, uint32_t nearest);
duet_point_query_result seek_points(duet_point_query *query, const duet_point *points, uint64_t n);
duet_box_query *open_box_query(duet_tree *tree);
duet_box_query_result join_boxes(duet_box_query *query, duet_object_kind kind, const void *boxes,
                                 uint64_t n);
duet_sweep_query *open_sweep_query(duet_tree *tree, duet_query_wants wants);
duet_sweep_query_result run_sweeps(duet_sweep_query *query, duet_object_kind kind,
                                   const void *sweeps, uint64_t n);

duet_contact_query *open_contact_query(duet_shape shape, uint32_t dims, uint32_t share,
                                       float margin);
// The pairs are given as two spans, one a third of them.
duet_contact_query_result find_contacts(duet_contact_query *query, duet_object_kind kind,
                                        const void *objects, uint32_t n, const duet_pair *pairs,
                                        uint64_t n_pairs);

#endif
