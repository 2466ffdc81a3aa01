// SPDX-License-Identifier: MIT
// device_pair:world: objects on two devices, stepped again and again.
#include "lua/nouns.h"

static const lua_class world_class;

static const char *pose_form_name(int value)
{
    static const char *const names[] = {"poses", "transforms", "compact"};
    return value <= DUET_POSE_COMPACT ? names[value] : NULL;
}

static const field def_fields[] = {
    FIELD(field_plan, duet_world_def, plan),
    FIELDS(duet_world_def, dims),
    FIELD_ENUM(duet_world_def, shape, shape_name),
    FIELD_ENUM(duet_world_def, level, level_name),
    FIELDS(duet_world_def, rotated, cell, cell_fixed, lower, upper),
    FIELD_ENUM(duet_world_def, pose_form, pose_form_name),
    FIELDS(duet_world_def, ordered, keep_bad, max_pairs, stage_times),
    FIELD(field_accuracy, duet_world_def, accuracy),
    {0},
};

world_box *world_check(lua_State *L)
{
    world_box *box = luaL_checkudata(L, 1, world_class.name);
    luaL_argcheck(L, box->world, 1, "the world is closed");
    return box;
}

void world_forget_views(world_box *box)
{
    ++box->maps;
    ++box->size_maps;
}

// ---------------------------------------------------------------- making

static duet_world_def read_def(lua_State *L, duet_device_pair *pair, const duet_scene *scene,
                               int index)
{
    duet_world_def def = scene ? duet_scene_world_def(scene, pair) : duet_default_world_def();
    def.pair = pair;
    if (lua_isnoneornil(L, index))
        return def;
    uint64_t given = field_read(L, index, "a world", def_fields, &def);
    bool lower = field_is_given(def_fields, given, "lower");
    bool upper = field_is_given(def_fields, given, "upper");
    if (lower != upper)
        luaL_error(L, "a world has both corners, lower and upper, or neither");
    def.has_world = def.has_world || lower;
    if (field_is_given(def_fields, given, "accuracy"))
        def.has_accuracy = true;
    else if (field_is_given(def_fields, given, "level"))
        def.has_accuracy = false;
    return def;
}

// device_pair:world(def), or device_pair:world(scene, def): with the scene's
// objects, and its settings where def says nothing else.
static int device_pair_world(lua_State *L)
{
    duet_error err = {0};
    duet_device_pair *pair = device_pair_check(L);
    const duet_scene *scene = lua_isuserdata(L, 2) ? scene_check(L, 2) : NULL;
    duet_world_def def = read_def(L, pair, scene, scene ? 3 : 2);
    world_box *box = class_push_of(L, &world_class, sizeof *box, 1);
    box->world = duet_world_create(&def, &err);
    if (!box->world)
        return class_push_failure(L, &err);
    if (scene && !duet_world_set_scene(box->world, scene, &err))
        return class_push_failure(L, &err);
    return 1;
}

static int world_close(lua_State *L)
{
    world_box *box = luaL_checkudata(L, 1, world_class.name);
    if (!box->world)
        return 0;
    luaL_argcheck(L, box->onlines == 0, 1, "an online plan steps the world: close that first");
    duet_world_destroy(box->world);
    box->world = NULL;
    ++box->steps;
    world_forget_views(box);
    return 0;
}

// ---------------------------------------------------------------- objects

static uint32_t check_number(lua_State *L, int index, const array *a)
{
    luaL_argcheck(L, a->n <= UINT32_MAX, index, "more than 2^32 - 1 objects");
    return (uint32_t)a->n;
}

// world:set_poses(rows) and others; the upvalue is the kind of rows.
static int world_set_objects(lua_State *L)
{
    duet_error err = {0};
    array_kind rows = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    world_box *box = world_check(L);
    const array *a = array_check(L, 2, rows);
    bool ok = duet_world_set_objects(box->world, array_object_kind(rows), a->rows,
                                     check_number(L, 2, a), &err);
    world_forget_views(box);
    return class_push_done(L, ok, &err);
}

static int world_set_scene(lua_State *L)
{
    duet_error err = {0};
    world_box *box = world_check(L);
    bool ok = duet_world_set_scene(box->world, scene_check(L, 2), &err);
    world_forget_views(box);
    return class_push_done(L, ok, &err);
}

// world:map_poses(n) and others; the upvalue is the kind of rows.
//
// Views of memory that was mapped before no longer hold: what is written there
// after a step is not sent to the devices.
static int world_map_objects(lua_State *L)
{
    duet_error err = {0};
    array_kind rows = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    world_box *box = world_check(L);
    uint64_t *maps = rows == ARRAY_SIZES ? &box->size_maps : &box->maps;
    lua_Integer n = luaL_checkinteger(L, 2);
    luaL_argcheck(L, n >= 0 && n <= UINT32_MAX, 2, "a number of objects from 0 to 2^32 - 1");
    ++*maps;
    void *memory = duet_world_map_objects(box->world, array_object_kind(rows), (uint32_t)n, &err);
    if (!memory)
        return class_push_failure(L, &err);
    array_push_view(L, rows, ARRAY_OPEN, memory, (uint64_t)n, maps);
    return 1;
}

static int world_order(lua_State *L)
{
    duet_error err = {0};
    uint32_t *order = NULL, n = 0;
    world_box *box = world_check(L);
    array *a = array_push_empty(L, ARRAY_PLACES);
    if (!duet_world_order(box->world, &order, &n, &err))
        return class_push_failure(L, &err);
    array_own(a, order, n);
    return 1;
}

// ---------------------------------------------------------------- stepping

// world:plan(), or nil while a step is under way
static int world_plan(lua_State *L)
{
    return plan_push(L, duet_world_get_plan(world_check(L)->world));
}

// Fields that the table leaves out stay as they are.
static int world_set_plan(lua_State *L)
{
    duet_error err = {0};
    world_box *box = world_check(L);
    const duet_plan *now = duet_world_get_plan(box->world);
    duet_plan plan = now ? *now : duet_default_plan(NULL);
    plan_read(L, &plan);
    return class_push_done(L, duet_world_set_plan(box->world, &plan, &err), &err);
}

static int world_level(lua_State *L)
{
    lua_pushstring(L, level_name(duet_world_get_level(world_check(L)->world)));
    return 1;
}

static int world_set_level(lua_State *L)
{
    duet_error err = {0};
    world_box *box = world_check(L);
    return class_push_done(L, duet_world_set_level(box->world, level_check(L, 2), &err), &err);
}

static int world_step(lua_State *L)
{
    duet_error err = {0};
    duet_result result = {0};
    world_box *box = world_check(L);
    ++box->steps;
    world_forget_views(box);
    if (!duet_world_step(box->world, &result, &err))
        return class_push_failure(L, &err);
    result_push(L, 1, &result);
    return 1;
}

static int world_step_begin(lua_State *L)
{
    duet_error err = {0};
    world_box *box = world_check(L);
    bool ok = duet_world_step_begin(box->world, &err);
    if (ok) {
        ++box->steps;
        world_forget_views(box);
    }
    return class_push_done(L, ok, &err);
}

static int world_step_end(lua_State *L)
{
    duet_error err = {0};
    duet_result result = {0};
    if (!duet_world_step_end(world_check(L)->world, &result, &err))
        return class_push_failure(L, &err);
    result_push(L, 1, &result);
    return 1;
}

// Says what its next step does.
static int world_about(lua_State *L)
{
    const duet_world *world = world_check(L)->world;
    const duet_plan *plan = duet_world_get_plan(world);
    if (!plan) {
        lua_pushliteral(L, "a step is under way");
        return 1;
    }
    lua_pushfstring(L, "share = %f, mode = %s, variant_a = %s, variant_b = %s, level = %s",
                    (double)plan->share / DUET_SHARE_ONE, duet_mode_name(plan->mode),
                    plan->variant_a, plan->variant_b, level_name(duet_world_get_level(world)));
    return 1;
}

static const lua_class world_class = {.name = "duet.world", .about = world_about};

const lua_noun world_noun = {
    {&world_class},
    (const lua_method[]){
        METHODS(device_pair, world),
        METHODS(world, close, set_scene, order, plan, set_plan, set_level, level, step, step_begin,
                step_end),
        {"duet.world:set_poses", world_set_objects, ARRAY_POSES},
        {"duet.world:set_bounds", world_set_objects, ARRAY_BOUNDS},
        {"duet.world:set_rounded_boxes", world_set_objects, ARRAY_ROUNDED_BOXES},
        {"duet.world:set_spheres", world_set_objects, ARRAY_SPHERES},
        {"duet.world:map_poses", world_map_objects, ARRAY_POSES},
        {"duet.world:map_bounds", world_map_objects, ARRAY_BOUNDS},
        {"duet.world:map_rounded_boxes", world_map_objects, ARRAY_ROUNDED_BOXES},
        {"duet.world:map_spheres", world_map_objects, ARRAY_SPHERES},
        {"duet.world:map_transforms", world_map_objects, ARRAY_TRANSFORMS},
        {"duet.world:map_compact_transforms", world_map_objects, ARRAY_COMPACT_TRANSFORMS},
        {"duet.world:map_sizes", world_map_objects, ARRAY_SIZES},
        {0}}};
