// SPDX-License-Identifier: MIT
// A tree of a motion's bodies. If the motion is on the tree's devices, B writes them from its
// state; the host gets them if A or an open hit needs them.
#include "base/error.h"
#include "runtime/bodies/ground_def.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_poses.h"
#include "runtime/narrowphase/mesh.h"
#include "runtime/queries/tree.h"

#include <stdlib.h>

duet_tree_def duet_motion_tree_def(const duet_motion *motion)
{
    duet_tree_def def = duet_default_tree_def();
    if (!motion)
        return def;
    bool radii = motion_has_radii(motion) || (motion->effects & DUET_EFFECT_RADIUS);
    def.pair = motion->def.pair;
    def.dims = motion->def.dims;
    def.shape = radii ? DUET_SHAPE_ROUNDED_BOXES : DUET_SHAPE_POSES;
    def.origin_edge = radii ? 0.0f : motion->def.origin_edge;
    return def;
}

static bool check(const duet_tree *tree, const duet_motion *motion, duet_error *err)
{
    if (tree->def.shape != DUET_SHAPE_POSES && tree->def.shape != DUET_SHAPE_ROUNDED_BOXES)
        return bad_argument(err, "a motion's bodies are poses or rounded boxes; the tree is of %s",
                            tree_shape_name(tree));
    if (tree->def.shape == DUET_SHAPE_POSES && motion_has_radii(motion))
        return bad_argument(
            err,
            "the motion's bodies have radii; the tree is of poses, expected one of rounded boxes");
    if (tree->def.origin_edge > 0.0f && tree->def.origin_edge != motion->def.origin_edge)
        return bad_argument(err, "the motion has the origin_edge %g; the tree has %g",
                            (double)motion->def.origin_edge, (double)tree->def.origin_edge);
    return tree->def.dims == motion->def.dims ||
           bad_argument(err, "the motion has dims %u; the tree has %u", motion->def.dims,
                        tree->def.dims);
}

// Poses are written on B if B has them, or go by way of the host.
static bool write_on_b(duet_tree *tree, duet_motion *motion, bool radii, duet_error *err)
{
    tree_side *b = &tree->sides[1];
    return box_tree_hold(&b->boxes, motion->device, tree->objects, tree->n, err) &&
           motion_write_poses(motion, radii, &b->boxes.objects, err);
}

static bool copy_to_host(duet_tree *tree, duet_motion *motion, bool radii, duet_error *err)
{
    if (!(tree->def.origin_edge > 0.0f))
        return motion_copy_poses(motion, radii, tree->objects, err);
    if (!motion_copy_large_poses(motion, tree->objects, err))
        return false;
    tree_find_middle(tree);
    return true;
}

static bool take_filters(duet_tree *tree, const duet_motion *motion, duet_error *err)
{
    if (!(motion->facts & FACT_FILTERED) && !(motion->effects & DUET_EFFECT_FILTER))
        return true;
    duet_filter *filters = tree_reserve_filters(tree, err);
    for (uint32_t i = 0; filters && i < tree->n; ++i)
        filters[i] = (duet_filter){motion->bodies[i].group, motion->bodies[i].mask};
    return filters;
}

// The motion's ground, where it is.
static bool take_ground(duet_tree *tree, duet_motion *motion, duet_error *err)
{
    const duet_motion_def *def = &motion->def;
    uint32_t carrier = ground_def_carrier(def);
    duet_mesh carried;
    duet_state state;
    if (carrier == 0)
        return tree_take_ground(tree, def->heights, def->mesh, err);
    if (!motion_fetch_states(motion, &(uint32_t){carrier - 1}, 1, &state, NULL, err) ||
        !mesh_carry(&carried, def->mesh, &state, err))
        return false;
    bool ok = tree_take_ground(tree, NULL, &carried, err);
    free((void *)carried.vertices);
    return ok;
}

bool duet_tree_set_motion(duet_tree *tree, duet_motion *motion, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(tree, __func__, "tree", err) || !motion_is_whole(motion, __func__, err) ||
        !check(tree, motion, err))
        return false;
    bool radii = tree->def.shape == DUET_SHAPE_ROUNDED_BOXES;
    bool on_b =
        motion->n > 0 && motion_has_poses(motion, radii) && motion->def.pair == tree->def.pair;
    if (!take_ground(tree, motion, err) || !tree_reserve_objects(tree, motion->n, err))
        return false;
    if (!take_filters(tree, motion, err) ||
        !(on_b ? write_on_b(tree, motion, radii, err) : copy_to_host(tree, motion, radii, err))) {
        tree_clear(tree);
        return false;
    }
    return tree_build(tree, motion_count_hidden(motion), on_b, err);
}
