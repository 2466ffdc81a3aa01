// SPDX-License-Identifier: MIT
#include "support/trees.h"

#include "support/devices.h"
#include "support/test.h"

static duet_tree *open_of(duet_shape shape, uint32_t dims, uint32_t share)
{
    duet_error err = {0};
    duet_tree_def def = duet_default_tree_def();
    def.pair = devices;
    def.shape = shape;
    def.dims = dims;
    def.share = share;
    duet_tree *tree = duet_tree_create(&def, &err);
    assert_ok(tree, err);
    return tree;
}

void set_poses(duet_tree *tree, const duet_pose *poses, uint32_t n)
{
    duet_error err = {0};
    assert_ok(duet_tree_set_objects(tree, DUET_OBJECT_POSES, poses, n, &err), err);
}

duet_tree *open_tree(uint32_t dims, uint32_t share, const duet_pose *poses, uint32_t n)
{
    duet_tree *tree = open_of(DUET_SHAPE_POSES, dims, share);
    set_poses(tree, poses, n);
    return tree;
}

duet_tree *open_bounds_tree(uint32_t dims, uint32_t share, const duet_bounds *bounds, uint32_t n)
{
    duet_error err = {0};
    duet_tree *tree = open_of(DUET_SHAPE_BOUNDS, dims, share);
    assert_ok(duet_tree_set_objects(tree, DUET_OBJECT_BOUNDS, bounds, n, &err), err);
    return tree;
}
