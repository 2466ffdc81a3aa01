// SPDX-License-Identifier: MIT
// duet.scene: objects with the world they live in, from a file or from rows.
#include "base/budget.h"
#include "lua/nouns.h"
#include "lua/policy.h"

typedef struct scene_box {
    duet_scene *scene;
    uint64_t closings; // views of the objects hold while it is 0
    size_t bytes;      // the host's memory that it holds
} scene_box;

const char *shape_name(int value)
{
    static const char *const names[DUET_SHAPES] = {"poses", "bounds", "rounded boxes", "spheres"};
    return value < DUET_SHAPES ? names[value] : NULL;
}

static const lua_class scene_class;

static const field info_fields[] = {
    FIELDS(duet_scene_info, name, dims),
    FIELD_ENUM(duet_scene_info, shape, shape_name),
    FIELDS(duet_scene_info, n, rotated, cell, cell_fixed, has_world, lower, upper),
    FIELD_ENUM(duet_scene_info, level, level_name),
    FIELDS(duet_scene_info, has_accuracy),
    FIELD(field_accuracy, duet_scene_info, accuracy),
    FIELDS(duet_scene_info, origin_edge),
    {0},
};

static scene_box *check_box(lua_State *L, int index)
{
    scene_box *box = luaL_checkudata(L, index, scene_class.name);
    luaL_argcheck(L, box->scene, index, "the scene is closed");
    return box;
}

duet_scene *scene_check(lua_State *L, int index)
{
    return check_box(L, index)->scene;
}

static const void *info_of(lua_State *L)
{
    return duet_scene_get_info(scene_check(L, 1));
}

void scene_push_info(lua_State *L, const duet_scene_info *info)
{
    field_push_table(L, info_fields, info);
}

// ---------------------------------------------------------------- making

// Pushes the value on top as text.
static const char *push_value(lua_State *L, const char *name)
{
    field_push_raw(L, -1);
    if (!field_text(L, -1))
        luaL_error(L, "%s is %s; expected a number, true, false or a string without NUL", name,
                   field_push_shown(L, -1));
    return field_text(L, -1);
}

const duet_setting *scene_read_settings(lua_State *L, int index, uint32_t *n)
{
    *n = 0;
    if (lua_isnoneornil(L, index))
        return NULL;
    luaL_checktype(L, index, LUA_TTABLE);
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1))
        ++*n;
    duet_setting *settings = lua_newuserdatauv(L, (*n + 1) * sizeof *settings, 0);
    lua_newtable(L);
    uint32_t i = 0;
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1), ++i) {
        if (!field_text(L, -2))
            luaL_error(L, "the settings of a scene are names with values");
        settings[i].name = field_text(L, -2);
        settings[i].value = push_value(L, settings[i].name);
        lua_rawseti(L, -4, (lua_Integer)i + 1);
    }
    return settings;
}

// The scene, or why there is none; counts what it holds of the host's memory.
static int finish(lua_State *L, scene_box *box, const duet_error *err)
{
    if (!box->scene)
        return class_push_failure(L, err);
    static const size_t bytes[DUET_SHAPES] = {sizeof(duet_pose), sizeof(duet_bounds),
                                              sizeof(duet_rounded_box), sizeof(duet_sphere)};
    size_t row = bytes[duet_scene_get_info(box->scene)->shape];
    row += duet_scene_get_bodies(box->scene) ? sizeof(duet_body) : 0;
    box->bytes = row * duet_scene_get_info(box->scene)->n;
    budget_hold(box->bytes);
    return 1;
}

static int scene_load(lua_State *L)
{
    duet_error err = {0};
    uint32_t n = 0;
    const char *path = text_check(L, 1);
    const duet_setting *settings = scene_read_settings(L, 2, &n);
    policy_check_read(L, path);
    scene_box *box = class_push(L, &scene_class, sizeof *box);
    box->scene = duet_scene_load(path, settings, n, &err);
    return finish(L, box, &err);
}

// duet.scene(path, settings), or duet.scene(poses, bounds, rounded boxes or spheres, dims)
static int scene_make(lua_State *L)
{
    duet_error err = {0};
    if (!lua_isuserdata(L, 1))
        return scene_load(L);
    lua_Integer dims = luaL_optinteger(L, 2, 3);
    luaL_argcheck(L, dims == 2 || dims == 3, 2, "2 or 3 dimensions");
    const array *given = array_test(L);
    bool others = given && (given->kind == ARRAY_BOUNDS || given->kind == ARRAY_ROUNDED_BOXES ||
                            given->kind == ARRAY_SPHERES);
    array_kind rows = others ? given->kind : ARRAY_POSES;
    const array *a = array_check(L, 1, rows);
    luaL_argcheck(L, a->n <= UINT32_MAX, 1, "more than 2^32 - 1 objects");
    uint32_t n = (uint32_t)a->n;
    scene_box *box = class_push(L, &scene_class, sizeof *box);
    box->scene = duet_scene_create(array_object_kind(rows), a->rows, n, (uint32_t)dims, 0, &err);
    return finish(L, box, &err);
}

// duet.load_pairs(path)
static int scene_load_pairs(lua_State *L)
{
    duet_error err = {0};
    const char *path = text_check(L, 1);
    policy_check_read(L, path);
    scene_box *box = class_push(L, &scene_class, sizeof *box);
    box->scene = duet_scene_load_pairs(path, &err);
    return finish(L, box, &err);
}

static int scene_close(lua_State *L)
{
    scene_box *box = luaL_checkudata(L, 1, scene_class.name);
    duet_scene_destroy(box->scene);
    budget_release(box->bytes);
    box->scene = NULL;
    box->bytes = 0;
    box->closings = 1;
    return 0;
}

// ---------------------------------------------------------------- reading

// A view of the scene's memory, or nil if it has no such rows.
static int push_rows(lua_State *L, array_kind kind, const void *rows)
{
    scene_box *box = check_box(L, 1);
    if (!rows) {
        lua_pushnil(L);
        return 1;
    }
    array_push_view(L, kind, ARRAY_FIXED, (void *)rows, duet_scene_get_info(box->scene)->n,
                    &box->closings);
    return 1;
}

// scene:poses() and others; the upvalue is the kind of rows.
static int scene_objects(lua_State *L)
{
    array_kind kind = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    return push_rows(L, kind, duet_scene_get_objects(scene_check(L, 1), array_object_kind(kind)));
}

static int scene_bodies(lua_State *L)
{
    return push_rows(L, ARRAY_BODIES, duet_scene_get_bodies(scene_check(L, 1)));
}

// scene:reference(), or scene:reference(level)
static int scene_reference(lua_State *L)
{
    duet_error err = {0};
    const duet_scene *scene = scene_check(L, 1);
    duet_level level = lua_isnoneornil(L, 2) ? DUET_LEVEL_CERTIFIED : level_check(L, 2);
    array *found = array_push_empty(L, ARRAY_PAIRS);
    duet_pair *pairs = NULL;
    uint64_t n = 0;
    if (!duet_reference(scene, level, &pairs, &n, &err))
        return class_push_failure(L, &err);
    array_own(found, pairs, n);
    return 1;
}

static int scene_length(lua_State *L)
{
    lua_pushinteger(L, duet_scene_get_info(scene_check(L, 1))->n);
    return 1;
}

static const lua_class scene_class = {
    .name = "duet.scene", .fields = info_fields, .struct_of = info_of};

const lua_noun scene_noun = {
    {&scene_class},
    (const lua_method[]){{"duet.scene", scene_make, 0},
                         {"duet.load_pairs", scene_load_pairs, 0},
                         METHODS(scene, close, bodies, reference),
                         {"duet.scene:poses", scene_objects, ARRAY_POSES},
                         {"duet.scene:bounds", scene_objects, ARRAY_BOUNDS},
                         {"duet.scene:rounded_boxes", scene_objects, ARRAY_ROUNDED_BOXES},
                         {"duet.scene:spheres", scene_objects, ARRAY_SPHERES},
                         {"duet.scene:__len", scene_length, 0},
                         {0}}};
