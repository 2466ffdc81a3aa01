// SPDX-License-Identifier: MIT
// device_pair:tree: boxes that queries ask about.
#include "lua/nouns.h"

#include <math.h>

const char *query_wants_name(int wants)
{
    return duet_query_wants_name((duet_query_wants)wants);
}

typedef struct tree_box {
    duet_tree *tree;
    int shape; // or TREE_LARGE_POSES
} tree_box;

static const lua_class tree_class;

static const member def_members[] = {
    MEMBER(member_share, duet_tree_def, share),
    MEMBER(member_count, duet_tree_def, dims),
    MEMBER_ENUM(duet_tree_def, shape, shape_name),
    MEMBER(member_float, duet_tree_def, origin_edge),
    {0},
};

// device_pair:tree(def)
int tree_create_lua(lua_State *L)
{
    duet_error err = {0};
    duet_tree_def def = duet_default_tree_def();
    def.pair = device_pair_check(L, 1);
    if (!lua_isnoneornil(L, 2))
        member_read_table(L, 2, "a tree", def_members, &def);
    tree_box *box = class_push(L, &tree_class, sizeof *box);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    box->shape = def.origin_edge > 0 ? TREE_LARGE_POSES : (int)def.shape;
    box->tree = duet_tree_create(&def, &err);
    return box->tree ? 1 : class_push_failure(L, &err);
}

static tree_box *box_check(lua_State *L, int index)
{
    tree_box *box = luaL_checkudata(L, index, tree_class.name);
    luaL_argcheck(L, box->tree, index, "the tree is closed");
    return box;
}

duet_tree *tree_check(lua_State *L, int index)
{
    return box_check(L, index)->tree;
}

static const struct {
    array_kind array;
    duet_object_kind objects;
} kinds[DUET_SHAPES + 1] = {
    [DUET_SHAPE_POSES] = {ARRAY_POSES, DUET_OBJECT_POSES},
    [DUET_SHAPE_BOUNDS] = {ARRAY_BOUNDS, DUET_OBJECT_BOUNDS},
    [DUET_SHAPE_ROUNDED_BOXES] = {ARRAY_ROUNDED_BOXES, DUET_OBJECT_ROUNDED_BOXES},
    [DUET_SHAPE_SPHERES] = {ARRAY_SPHERES, DUET_OBJECT_SPHERES},
    [TREE_LARGE_POSES] = {ARRAY_LARGE_POSES, DUET_OBJECT_LARGE_POSES},
};

array_kind shape_array_kind(duet_shape shape)
{
    return kinds[shape].array;
}

int tree_shape(lua_State *L, int index)
{
    return box_check(L, index)->shape;
}

duet_object_kind tree_object_kind(array_kind kind)
{
    int i = 0;
    while (kinds[i].array != kind)
        ++i;
    return kinds[i].objects;
}

// tree:set_objects(poses or bounds) -> tree
static int tree_set_objects(lua_State *L)
{
    duet_error err = {0};
    tree_box *box = box_check(L, 1);
    const array *objects = array_check(L, 2, kinds[box->shape].array);
    duet_object_kind kind = kinds[box->shape].objects;
    luaL_argcheck(L, objects->n <= UINT32_MAX, 2, "fewer than 2^32 rows");
    if (!duet_tree_set_objects(box->tree, kind, objects->rows, (uint32_t)objects->n, &err))
        return class_push_failure(L, &err);
    lua_settop(L, 1);
    return 1;
}

// tree:set_motion(motion) -> tree
static int tree_set_motion(lua_State *L)
{
    duet_error err = {0};
    if (!duet_tree_set_motion(tree_check(L, 1), motion_check_at(L, 2), &err))
        return class_push_failure(L, &err);
    lua_settop(L, 1);
    return 1;
}

// tree:set_share(share) -> tree
static int tree_set_share(lua_State *L)
{
    duet_error err = {0};
    duet_tree *tree = tree_check(L, 1);
    lua_Number share = luaL_checknumber(L, 2);
    luaL_argcheck(L, share >= 0 && share <= 1, 2, "a share from 0 to 1");
    if (!duet_tree_set_share(tree, (uint32_t)lround(share * DUET_SHARE_ONE), &err))
        return class_push_failure(L, &err);
    lua_settop(L, 1);
    return 1;
}

static int tree_close(lua_State *L)
{
    tree_box *box = luaL_checkudata(L, 1, tree_class.name);
    duet_tree_destroy(box->tree);
    box->tree = NULL;
    return 0;
}

static const luaL_Reg methods[] = {{"close", tree_close},
                                   {"set_objects", tree_set_objects},
                                   {"set_motion", tree_set_motion},
                                   {"set_share", tree_set_share},
                                   {"load_profile", tree_load_profile_lua},
                                   {NULL, NULL}};
static const lua_class tree_class = {
    .name = "duet.tree", .methods = methods, .more_methods = tree_query_methods};

void tree_open_lua(lua_State *L)
{
    class_open(L, &tree_class);
    lua_pushinteger(L, DUET_NO_OBJECT);
    lua_setfield(L, -2, "NO_OBJECT");
}
