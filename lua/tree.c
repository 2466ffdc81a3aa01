// SPDX-License-Identifier: MIT
// device_pair:tree: boxes that queries ask about.
#include "lua/motion.h"

#include <math.h>

const char *query_wants_name(int wants)
{
    return duet_query_wants_name((duet_query_wants)wants);
}

typedef struct tree_box {
    lua_handle tree;
    int shape; // or TREE_LARGE_POSES
} tree_box;

CLASS_DESTROY(tree)
static const lua_class tree_class = {.name = "duet.tree", .destroy = destroy_tree, .noun = "tree"};

static const field def_fields[] = {
    FIELD(field_share, duet_tree_def, share),
    FIELDS(duet_tree_def, dims),
    FIELD_ENUM(duet_tree_def, shape, shape_name),
    FIELDS(duet_tree_def, origin_edge),
    {0},
};

// device_pair:tree(def), or (motion, def): of its bodies
static int device_pair_tree(lua_State *L)
{
    duet_error err = {0};
    duet_device_pair *pair = device_pair_check(L);
    duet_motion *motion = lua_isuserdata(L, 2) ? motion_check_at(L, 2) : NULL;
    duet_tree_def def = duet_motion_tree_def(motion);
    def.pair = pair;
    field_read(L, motion ? 3 : 2, "a tree", def_fields, &def);
    tree_box *box = class_push_of(L, &tree_class, sizeof *box, 1);
    box->shape = def.origin_edge > 0 ? TREE_LARGE_POSES : (int)def.shape;
    box->tree.object = duet_tree_create(&def, &err);
    bool ok = box->tree.object && (!motion || duet_tree_set_motion(box->tree.object, motion, &err));
    return ok ? 1 : class_push_failure(L, &err);
}

duet_tree *tree_check(lua_State *L)
{
    return class_object(L, 1, &tree_class);
}

static const array_kind rows_of[DUET_SHAPES + 1] = {
    [DUET_SHAPE_POSES] = ARRAY_POSES,
    [DUET_SHAPE_BOUNDS] = ARRAY_BOUNDS,
    [DUET_SHAPE_ROUNDED_BOXES] = ARRAY_ROUNDED_BOXES,
    [DUET_SHAPE_SPHERES] = ARRAY_SPHERES,
    [TREE_LARGE_POSES] = ARRAY_LARGE_POSES,
};

array_kind shape_array_kind(int shape)
{
    return rows_of[shape];
}

int tree_shape(lua_State *L)
{
    return ((const tree_box *)class_check(L, 1, &tree_class))->shape;
}

// Pushes the tree at 1 if what was asked of it is done, else nil and an error.
static int push_tree(lua_State *L, bool ok, const duet_error *err)
{
    if (!ok)
        return class_push_failure(L, err);
    lua_settop(L, 1);
    return 1;
}

// tree:set_objects(poses or bounds) -> tree
static int tree_set_objects(lua_State *L)
{
    duet_error err = {0};
    const tree_box *box = class_check(L, 1, &tree_class);
    const array *objects = array_check(L, 2, rows_of[box->shape]);
    duet_object_kind kind = array_object_kind(objects->kind);
    luaL_argcheck(L, objects->n <= UINT32_MAX, 2, "fewer than 2^32 rows");
    return push_tree(
        L, duet_tree_set_objects(box->tree.object, kind, objects->rows, (uint32_t)objects->n, &err),
        &err);
}

// tree:set_motion(motion) -> tree
static int tree_set_motion(lua_State *L)
{
    duet_error err = {0};
    return push_tree(L, duet_tree_set_motion(tree_check(L), motion_check_at(L, 2), &err), &err);
}

// The table behind a tree, which becomes the only other argument; nil: there is none.
static bool check_ground(lua_State *L)
{
    lua_settop(L, 2);
    if (!lua_isnil(L, 2))
        luaL_checktype(L, 2, LUA_TTABLE);
    return !lua_isnil(L, 2);
}

// tree:set_heights { nx = 65, ... } -> tree; without a table there is no ground
static int tree_set_heights(lua_State *L)
{
    duet_error err = {0};
    duet_tree *tree = tree_check(L);
    const duet_heights *heights = check_ground(L) ? motion_push_heights(L) : NULL;
    return push_tree(L, duet_tree_set_heights(tree, heights, &err), &err);
}

// tree:set_mesh { file = "drum.stl" } -> tree; likewise
static int tree_set_mesh(lua_State *L)
{
    duet_error err = {0};
    duet_tree *tree = tree_check(L);
    const duet_mesh *mesh = check_ground(L) ? motion_push_mesh(L) : NULL;
    return push_tree(L, duet_tree_set_mesh(tree, mesh, &err), &err);
}

// tree:set_filters(filters) -> tree
static int tree_set_filters(lua_State *L)
{
    duet_error err = {0};
    duet_tree *tree = tree_check(L);
    const array *filters = array_check(L, 2, ARRAY_FILTERS);
    luaL_argcheck(L, filters->n <= UINT32_MAX, 2, "fewer than 2^32 rows");
    return push_tree(L, duet_tree_set_filters(tree, filters->rows, (uint32_t)filters->n, &err),
                     &err);
}

// tree:set_share(share) -> tree
static int tree_set_share(lua_State *L)
{
    duet_error err = {0};
    duet_tree *tree = tree_check(L);
    lua_Number share = luaL_checknumber(L, 2);
    luaL_argcheck(L, share >= 0 && share <= 1, 2, "a share from 0 to 1");
    return push_tree(L, duet_tree_set_share(tree, (uint32_t)lround(share * DUET_SHARE_ONE), &err),
                     &err);
}

const lua_noun tree_noun = {{&tree_class},
                            (const lua_method[]){METHODS(device_pair, tree),
                                                 METHODS(tree, set_objects, set_motion, set_heights,
                                                         set_mesh, set_filters, set_share),
                                                 {0}}};
