// SPDX-License-Identifier: MIT
#include "support/trees.h"

#include "support/devices.h"
#include "support/test.h"

static duet_tree *open_of(duet_shape shape, uint32_t dims, uint32_t share)
{
    duet_tree_def def = duet_default_tree_def();
    def.pair = default_pair();
    def.shape = shape;
    def.dims = dims;
    def.share = share;
    return kept(duet_tree_create(&def, ERR));
}

void set_poses(duet_tree *tree, const duet_pose *poses, uint32_t n)
{
    must(duet_tree_set_objects(tree, DUET_OBJECT_POSES, poses, n, ERR));
}

duet_tree *open_tree(uint32_t dims, uint32_t share, const duet_pose *poses, uint32_t n)
{
    duet_tree *tree = open_of(DUET_SHAPE_POSES, dims, share);
    set_poses(tree, poses, n);
    return tree;
}

duet_tree *open_bounds_tree(uint32_t dims, uint32_t share, const duet_bounds *bounds, uint32_t n)
{
    duet_tree *tree = open_of(DUET_SHAPE_BOUNDS, dims, share);
    must(duet_tree_set_objects(tree, DUET_OBJECT_BOUNDS, bounds, n, ERR));
    return tree;
}

duet_tree *open_rounded_tree(uint32_t dims, uint32_t share, duet_object_kind kind,
                             const void *objects, uint32_t n)
{
    bool spheres = kind == DUET_OBJECT_SPHERES;
    duet_tree *tree = open_of(spheres ? DUET_SHAPE_SPHERES : DUET_SHAPE_ROUNDED_BOXES, dims, share);
    must(duet_tree_set_objects(tree, kind, objects, n, ERR));
    return tree;
}

duet_rounded_box draw_rounded(rng *r, uint32_t i)
{
    duet_rounded_box box = {.radius = (float)rng_between(r, 0.1, 0.6)};
    for (int k = 0; k < 4; ++k) {
        box.pose.rotation[k] = i % 4 == 0 ? k == 3 : (float)rng_normal(r);
        if (k == 3)
            break;
        box.pose.centre[k] = (float)rng_between(r, -4, 4);
        box.pose.half_extents[k] = i % 3 == 0 || (i % 3 == 1 && k > 0)
                                       ? 0
                                       : (float)rng_between(r, 0.05, i % 40 == 2 ? 4 : 0.6);
        if (i % 4 == 0) {
            box.pose.centre[k] = roundf(2 * box.pose.centre[k]) / 2;
            box.pose.half_extents[k] = roundf(4 * box.pose.half_extents[k]) / 4;
        }
    }
    if (i % 4 == 0)
        box.radius = 0.25f;
    if (i % 7 == 0)
        box.radius = i % 14 == 0 ? 0 : 1e-7f;
    return box;
}

duet_ray_query *open_ray_query(duet_tree *tree, duet_query_wants wants, bool normals)
{
    duet_ray_query_def def = duet_default_ray_query_def();
    def.tree = tree;
    def.wants = wants;
    def.normals = normals;
    return kept(duet_ray_query_create(&def, ERR));
}

duet_ray_query_result cast_rays(duet_ray_query *query, const duet_ray *rays, uint64_t n)
{
    duet_ray_query_result result;
    must(duet_ray_query_run(query, rays, n, &result, ERR));
    return result;
}

duet_point_query *open_point_query(duet_tree *tree, uint32_t nearest)
{
    duet_point_query_def def = duet_default_point_query_def();
    def.tree = tree;
    def.nearest = nearest;
    return kept(duet_point_query_create(&def, ERR));
}

duet_point_query_result seek_points(duet_point_query *query, const duet_point *points, uint64_t n)
{
    duet_point_query_result result;
    must(duet_point_query_run(query, points, n, &result, ERR));
    return result;
}

duet_box_query *open_box_query(duet_tree *tree)
{
    duet_box_query_def def = duet_default_box_query_def();
    def.tree = tree;
    return kept(duet_box_query_create(&def, ERR));
}

duet_box_query_result join_boxes(duet_box_query *query, duet_object_kind kind, const void *boxes,
                                 uint64_t n)
{
    duet_box_query_result result;
    must(duet_box_query_run(query, kind, boxes, n, &result, ERR));
    return result;
}

duet_sweep_query *open_sweep_query(duet_tree *tree, duet_query_wants wants)
{
    duet_sweep_query_def def = duet_default_sweep_query_def();
    def.tree = tree;
    def.wants = wants;
    return kept(duet_sweep_query_create(&def, ERR));
}

duet_sweep_query_result run_sweeps(duet_sweep_query *query, duet_object_kind kind,
                                   const void *sweeps, uint64_t n)
{
    duet_sweep_query_result result;
    must(duet_sweep_query_run(query, kind, sweeps, n, &result, ERR));
    return result;
}

duet_contact_query *open_contact_query(duet_shape shape, uint32_t dims, uint32_t share,
                                       float margin)
{
    duet_contact_query_def def = duet_default_contact_query_def();
    def.pair = default_pair();
    def.shape = shape;
    def.dims = dims;
    def.share = share;
    def.margin = margin;
    return kept(duet_contact_query_create(&def, ERR));
}

duet_contact_query_result find_contacts(duet_contact_query *query, duet_object_kind kind,
                                        const void *objects, uint32_t n, const duet_pair *pairs,
                                        uint64_t n_pairs)
{
    const duet_span spans[2] = {{pairs, n_pairs / 3}, {pairs + n_pairs / 3, n_pairs - n_pairs / 3}};
    duet_contact_query_result result;
    must(duet_contact_query_run(query, kind, objects, n, spans, &result, ERR));
    assert_int_equal(result.n_contacts, n_pairs);
    return result;
}
