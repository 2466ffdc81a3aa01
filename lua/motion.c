// SPDX-License-Identifier: MIT
// device_pair:motion: objects that move, and push each other where they touch.
#include "lua/motion.h"
#include "lua/policy.h"
#include "runtime/scene/scene_fields.h"

static const lua_class motion_class;

// ---------------------------------------------------------------- making

// The objects that a motion is made of.
typedef struct motion_objects {
    duet_motion_def def;
    const duet_pose *poses;
    const duet_body *bodies; // NULL: all at rest
    uint32_t n;
} motion_objects;

static motion_objects objects_of_scene(lua_State *L, const duet_scene *scene,
                                       duet_device_pair *pair)
{
    motion_objects o = {.def = duet_scene_motion_def(scene, pair),
                        .poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES),
                        .bodies = duet_scene_get_bodies(scene),
                        .n = duet_scene_get_info(scene)->n};
    luaL_argcheck(L, duet_scene_get_info(scene)->shape != DUET_SHAPE_BOUNDS, 2,
                  "a scene of poses: bounds do not move");
    return o;
}

static motion_objects objects_of_arrays(lua_State *L, duet_device_pair *pair)
{
    const array *poses = array_check(L, 2, ARRAY_POSES);
    const array *bodies = lua_isnil(L, 3) ? NULL : array_check(L, 3, ARRAY_BODIES);
    luaL_argcheck(L, poses->n <= UINT32_MAX, 2, "more than 2^32 - 1 objects");
    luaL_argcheck(L, !bodies || bodies->n == poses->n, 3, "as many bodies as poses");
    motion_objects o = {.def = duet_default_motion_def(),
                        .poses = poses->rows,
                        .bodies = bodies ? bodies->rows : NULL,
                        .n = (uint32_t)poses->n};
    o.def.pair = pair;
    return o;
}

// Keeps what the motion on top of the stack needs: the pair at 1, and the script of the def.
static void keep_owners(lua_State *L, int def)
{
    lua_pushvalue(L, 1);
    lua_pushliteral(L, "script");
    if (lua_istable(L, def) && lua_rawget(L, def) == LUA_TFUNCTION) {
        lua_createtable(L, 2, 0);
        lua_insert(L, -3);
        lua_rawseti(L, -3, 2);
        lua_rawseti(L, -2, 1);
    } else {
        lua_pop(L, 1);
    }
    lua_setiuservalue(L, -2, 1);
}

// device_pair:motion(scene, def), or (poses, bodies, def); without bodies all
// are at rest.
static int device_pair_motion(lua_State *L)
{
    duet_error err = {0};
    lua_settop(L, 4);
    duet_device_pair *pair = device_pair_check(L);
    bool of_scene = luaL_testudata(L, 2, "duet.scene");
    motion_objects o =
        of_scene ? objects_of_scene(L, scene_check(L, 2), pair) : objects_of_arrays(L, pair);
    field_read(L, of_scene ? 3 : 4, "a motion", motion_def_fields, &o.def);
    motion_box *box = class_push(L, &motion_class, sizeof *box);
    keep_owners(L, of_scene ? 3 : 4);
    box->motion = of_scene ? duet_motion_create_from_scene(&o.def, scene_check(L, 2), NULL, &err)
                           : duet_motion_create(&o.def, o.poses, o.bodies, o.n, &err);
    return box->motion ? 1 : class_push_failure(L, &err);
}

motion_box *motion_check_box(lua_State *L, int index)
{
    motion_box *box = luaL_checkudata(L, index, motion_class.name);
    luaL_argcheck(L, box->motion, index, "the motion is closed");
    return box;
}

duet_motion *motion_check_at(lua_State *L, int index)
{
    return motion_check_box(L, index)->motion;
}

duet_motion *motion_check_lua(lua_State *L)
{
    return motion_check_at(L, 1);
}

static int motion_close(lua_State *L)
{
    motion_box *box = luaL_checkudata(L, 1, motion_class.name);
    if (!box->motion)
        return 0;
    duet_motion_destroy(box->motion);
    box->motion = NULL;
    ++box->steps;
    for (int part = 0; part < 4; ++part)
        ++box->maps[part];
    return 0;
}

uint64_t *motion_maps_lua(lua_State *L)
{
    return motion_check_box(L, 1)->maps;
}

// ---------------------------------------------------------------- what it is

static int motion_effects(lua_State *L)
{
    scene_push_effects(L, duet_motion_get_effects(motion_check_lua(L)));
    return 1;
}

// motion:set_plan(plan): what the table leaves out stays
static int motion_set_plan(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    const duet_motion_def *def = duet_motion_get_def(motion);
    duet_plan plan = def ? def->plan : duet_default_plan(NULL);
    plan_read(L, &plan);
    return class_push_done(L, duet_motion_set_plan(motion, &plan, &err), &err);
}

// motion:plan() -> the plan by which it seeks pairs; nil if it seeks none
static int motion_plan(lua_State *L)
{
    return plan_push(L, duet_motion_get_plan(motion_check_lua(L)));
}

static int motion_step(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)duet_motion_get_step(motion_check_lua(L)));
    return 1;
}

static int motion_length(lua_State *L)
{
    lua_pushinteger(L, duet_motion_get_count(motion_check_lua(L)));
    return 1;
}

// One table an effect.
static int motion_explain(lua_State *L)
{
    duet_effect_info info = {0};
    const duet_motion *motion = motion_check_lua(L);
    lua_newtable(L);
    for (uint32_t i = 0; duet_motion_explain(motion, i, &info); ++i) {
        field_push_table(L, FIELD_LIST(duet_effect_info, name, active, called_by, kernels, bytes),
                         &info);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static int motion_explain_substeps(lua_State *L)
{
    duet_substep_info info = {0};
    duet_motion_explain_substeps(motion_check_lua(L), &info);
    field_push_table(L, FIELD_LIST(duet_substep_info, substeps, chosen, layers, edge), &info);
    return 1;
}

// ---------------------------------------------------------------- files

static int motion_save(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    const char *path = text_check(L, 2);
    policy_check_trusted(L, "saving a motion");
    return class_push_done(L, duet_motion_save(motion, path, &err), &err);
}

static int motion_load(lua_State *L)
{
    duet_error err = {0};
    motion_box *box = motion_check_box(L, 1);
    const char *path = text_check(L, 2);
    policy_check_read(L, path);
    ++box->steps;
    return class_push_done(L, duet_motion_load(box->motion, path, &err), &err);
}

static int motion_record(lua_State *L)
{
    duet_error err = {0};
    return class_push_done(L, duet_motion_record(motion_check_lua(L), &err), &err);
}

static int motion_save_recording(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    const char *path = text_check(L, 2);
    policy_check_trusted(L, "saving a recording");
    return class_push_done(L, duet_motion_save_recording(motion, path, &err), &err);
}

// ---------------------------------------------------------------- the class

static int motion_about(lua_State *L)
{
    const duet_motion *motion = motion_check_lua(L);
    uint32_t effects = duet_motion_get_effects(motion);
    const char *before = "";
    lua_pushfstring(L, "objects = %d, effects = { ", (int)duet_motion_get_count(motion));
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1) {
        if (!(effects & bit))
            continue;
        lua_pushfstring(L, "%s%s", before, duet_effect_name(bit));
        lua_concat(L, 2);
        before = ", ";
    }
    lua_pushliteral(L, " }");
    lua_concat(L, 2);
    return 1;
}

static const lua_class motion_class = {
    .name = "duet.motion",
    .about = motion_about,
};

const lua_noun motion_noun = {
    {&motion_class},
    (const lua_method[]){METHODS(device_pair, motion),
                         METHODS(motion, effects, plan, set_plan, save, load, explain,
                                 explain_substeps, close, record, save_recording, step),
                         {"duet.motion:__len", motion_length, 0},
                         {0}}};
