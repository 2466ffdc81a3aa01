// SPDX-License-Identifier: MIT
// A scene as a Lua file: it adds objects while it runs, and returns a table
// with what else there is to say.
#include "runtime/scene/scene_lua.h"

#include "base/error.h"
#include "gen/parameters.h"
#include "gen/sandbox.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/scene/scene_fields.h"
#include "runtime/scene/scene_source.h"

#include <float.h>
#include <lauxlib.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- parameters
// A scene names what can be set from outside: parameters{n = 1000, seed = 1}.
//
// The default also says of which type a value must be, so that a mistyped
// setting is refused before it makes another scene.

// parameters{name = default, ...} -> the same with what was set from outside;
// upvalue 1 is the reading.
static int word_parameters(lua_State *L)
{
    scene_reading *reading = lua_touserdata(L, lua_upvalueindex(1));
    parameters_declare(L, &reading->declared);
    for (uint32_t i = 0; i < reading->n_settings; ++i)
        parameters_set(L, "the scene", reading->settings[i].name, reading->settings[i].value);
    if (lua_getfield(L, 1, "n") == LUA_TNUMBER && lua_tointeger(L, -1) > 0)
        reading->expected = (uint64_t)lua_tointeger(L, -1);
    reading->seed = parameters_seed(L);
    return 1;
}

// ---------------------------------------------------------------- a scene

// Enough for ten million objects by add, or a million in a list; an endless loop ends
// within seconds.
static const script_limits limits = {
    .memory_bytes = (size_t)512 << 20, .instructions = 1000000000, .seconds = 30};

// Whoever asks for n objects waits for them: several times what the shipped scenes take
// for each. The script's own default of n is not asked for.
static script_limits limits_for(const duet_setting *settings, uint32_t n_settings)
{
    enum { INSTRUCTIONS_AN_OBJECT = 250, NS_AN_OBJECT = 20000 };
    script_limits given = limits;
    for (uint32_t i = 0; i < n_settings; ++i) {
        double n = strcmp(settings[i].name, "n") == 0 ? strtod(settings[i].value, NULL) : 0;
        if (n > 0 && n <= UINT32_MAX) {
            given.instructions += INSTRUCTIONS_AN_OBJECT * (uint64_t)n;
            given.seconds += 1e-9 * NS_AN_OBJECT * n;
        }
    }
    return given;
}

static const struct {
    const char *name;
    lua_CFunction function;
} words[] = {
    {"add", scene_word_add},       {"each", scene_word_each},       {"euler", scene_word_euler},
    {"random", scene_word_random}, {"parameters", word_parameters},
};

// Gives the script its words. Argument 1: the reading.
static int open_words(lua_State *L)
{
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i) {
        lua_pushvalue(L, 1);
        lua_pushcclosure(L, words[i].function, 1);
        lua_setglobal(L, words[i].name);
    }
    return 0;
}

// ------------------------------------------------------------------ fields

// Each reads a field from the top of the stack into the scene.
static void read_name(lua_State *L, const field *f, void *at)
{
    const char *name = NULL;
    field_string.read(L, f, &name);
    if (!scene_set_name(at, name, strlen(name), scene_reading_of(L)->err))
        script_lacks_memory(L);
}

static void read_dims(lua_State *L, const field *f, void *at)
{
    duet_scene_info *info = &((duet_scene *)at)->info;
    uint32_t dims = 0;
    field_count.read(L, f, &dims);
    if (info->n > 0 && info->dims != dims)
        field_raise(L, "dims", "dims is %u, but the objects have %u", dims, info->dims);
    info->dims = dims;
}

// A corner of the world: as many numbers as there are dimensions.
static void read_corner(lua_State *L, const field *f, void *at)
{
    double corner[3] = {0};
    scene_read_by_dims(L, f, corner);
    for (int k = 0; k < 3; ++k)
        ((float *)at)[k] = (float)corner[k];
}

static const field_type corner = {.read = read_corner};

static const field world_fields[] = {
    FIELD(corner, duet_scene_info, lower),
    FIELD(corner, duet_scene_info, upper),
    {0},
};

static void read_world(lua_State *L, const field *f, void *at)
{
    duet_scene_info *info = &((duet_scene *)at)->info;
    (void)f;
    if (field_read_row(L, -1, (field_table){"world", -1, NULL}, world_fields, info) != 3)
        field_raise(L, "world", "world has one corner; expected lower and upper");
    for (uint32_t i = 0; i < info->dims; ++i)
        if (info->lower[i] > info->upper[i])
            field_raise(L, "world", "world's lower is above its upper");
    info->has_world = true;
}

static void read_accuracy(lua_State *L, const field *f, void *at)
{
    duet_scene_info *info = &((duet_scene *)at)->info;
    if (lua_getfield(L, 1, "level") != LUA_TNIL)
        field_raise(L, "accuracy", "a scene has a level, or an accuracy that one is chosen by");
    lua_pop(L, 1);
    field_accuracy.read(L, f, &info->accuracy);
    info->has_accuracy = true;
}

// In the order in which they are read: dims are checked against the objects, and world against
// dims.
static const field fields[] = {
    SCENE_FIELD("name", read_name),
    SCENE_FIELD("objects", scene_read_objects),
    {.name = "dims",
     .type = &(const field_type){.read = read_dims},
     .least = 2,
     .most = 3,
     .expected = "2 or 3"},
    SCENE_FIELD("world", read_world),
    FIELD_WITHIN(duet_scene, info., cell, 0, FLT_MAX, "an edge above 0, or 0 for one that fits"),
    FIELDS_IN(duet_scene, info., cell_fixed),
    FIELD_ENUM_AT("level", duet_scene, info.level, level_name),
    SCENE_FIELD("accuracy", read_accuracy),
    SCENE_FIELD("body", scene_read_body),
    SCENE_FIELD("gravity", scene_read_gravity),
    SCENE_FIELD("heights", scene_read_heights),
    SCENE_FIELD("mesh", scene_read_mesh),
    SCENE_FIELD("origin_edge", scene_read_origin_edge),
    SCENE_FIELD("origin", scene_read_origin),
    SCENE_FIELD("attraction", scene_read_attraction),
    SCENE_FIELD("boundary", scene_read_boundary),
    FIELD_IN(field_effects, duet_scene, motion., wants),
    FIELD_ENUM_AT("integrator", duet_scene, motion.integrator, scene_integrator_name),
    FIELD_AT("materials", field_materials, duet_scene, motion),
    FIELD_AT("material_pairs", field_material_pairs, duet_scene, motion),
    FIELDS_FROM_0(duet_scene, motion., drag, dt, skin, slop, max_push_speed, restitution_threshold,
                  sleep_speed, sleep_after, hit_speed),
    FIELD_WITHIN(duet_scene, motion., substeps, 0, 1000, "0 (chosen for the scene), or 1 to 1000"),
    FIELD_WITHIN(duet_scene, motion., event_mask, 0, UINT32_MAX, "a whole number below 2^32"),
    FIELDS_IN(duet_scene, motion., doubles),
    {0},
};

// Reads what the script returned. Argument 1: that, 2: the reading.
static int read_result(lua_State *L)
{
    scene_reading *reading = lua_touserdata(L, 2);
    if (!lua_istable(L, 1))
        return field_raise(L, NULL, "a scene must return a table, not %s", luaL_typename(L, 1));
    if (reading->n_settings > 0 && !reading->declared) {
        script_set_failure(L, DUET_STATUS_BAD_ARGUMENT);
        return field_raise(L, NULL, "no parameter '%s'; the scene declares none",
                           reading->settings[0].name);
    }
    if (lua_getfield(L, 1, "script") != LUA_TNIL)
        return field_raise(L, "script",
                           "a scene cannot act between steps; expected the function in the def of "
                           "pair:motion, in a script that 'duet lua' runs");
    lua_pop(L, 1);
    field_read(L, 1, "a scene", fields, reading->scene);
    if (!scene_fill_bodies(reading->scene, reading->err))
        script_lacks_memory(L);
    return 0;
}

bool scene_read_lua(duet_scene *scene, const scene_source *source, const duet_setting *settings,
                    uint32_t n_settings, duet_error *err)
{
    scene_reading reading = {.scene = scene,
                             .origin_edge = 1,
                             .path = source->name,
                             .settings = settings,
                             .n_settings = n_settings,
                             .err = err};
    script_limits given = limits_for(settings, n_settings);
    scene->mixes = true;
    script *s = sandbox_open(&given, err);
    if (!s)
        return false;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, open_words);
    lua_pushlightuserdata(L, &reading);
    bool ok = script_call(s, 1, 0, err);
    lua_pushcfunction(L, read_result);
    ok = ok && script_run(s, source->name, source->bytes, source->length, 1, err);
    lua_pushlightuserdata(L, &reading);
    ok = ok && script_call(s, 2, 0, err);
    script_close(s);
    return ok;
}
