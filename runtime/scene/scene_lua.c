// SPDX-License-Identifier: MIT
// A scene as a Lua file: it adds objects while it runs, and returns a table
// with what else there is to say.
#define _POSIX_C_SOURCE 200809L
#include "runtime/scene/scene_motion.h"

#include "base/blob.h"
#include "base/error.h"
#include "gen/field.h"
#include "gen/script.h"
#include "runtime/narrowphase/accuracy.h"

#include <lauxlib.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

// Enough for tens of millions of objects by add, or a million in a list; an
// endless loop ends within seconds.
static const script_limits limits = {
    .memory_bytes = (size_t)512 << 20, .instructions = 1000000000, .seconds = 30};

static const struct {
    const char *name;
    lua_CFunction function;
} words[] = {
    {"add", scene_word_add},
    {"euler", scene_word_euler},
    {"random", scene_word_random},
    {"parameters", scene_word_parameters},
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

// Each reads one field of the scene's table, which is at index 1.
static void read_name(lua_State *L, scene_reading *reading)
{
    const char *name = field_string(L, 1, "name", NULL);
    if (name && !scene_set_name(reading->scene, name, strlen(name), reading->err))
        luaL_error(L, "name: no memory");
}

static void read_objects(lua_State *L, scene_reading *reading)
{
    if (!field_push(L, 1, "objects", LUA_TTABLE))
        return;
    if (!scene_is_list(L))
        field_raise(L, "objects", "objects must be a list");
    lua_Unsigned n = lua_rawlen(L, -1);
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        scene_add_table(L, reading);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}

static void read_dims(lua_State *L, scene_reading *reading)
{
    duet_scene_info *info = &reading->scene->info;
    int64_t dims = field_integer(L, 1, "dims", info->dims);
    if (dims != 2 && dims != 3)
        field_raise(L, "dims", "dims is %lld; it must be 2 or 3", (long long)dims);
    if (info->n > 0 && info->dims != dims)
        field_raise(L, "dims", "dims is %lld, but the objects have %u", (long long)dims,
                    info->dims);
    info->dims = (uint32_t)dims;
}

// A corner of the world: as many numbers as there are dimensions.
static void read_corner(lua_State *L, const char *name, uint32_t dims, float *corner)
{
    bool ok = field_push(L, -1, name, LUA_TTABLE) && lua_rawlen(L, -1) == dims;
    for (uint32_t i = 0; ok && i < dims; ++i) {
        ok = lua_rawgeti(L, -1, (lua_Integer)i + 1) == LUA_TNUMBER;
        corner[i] = (float)lua_tonumber(L, -1);
        ok = ok && isfinite(corner[i]);
        lua_pop(L, 1);
    }
    if (!ok)
        field_raise(L, name, "world's %s must be %u finite numbers", name, dims);
    lua_pop(L, 1);
}

static void read_world(lua_State *L, scene_reading *reading)
{
    static const char *const corners[] = {"lower", "upper", NULL};
    duet_scene_info *info = &reading->scene->info;
    if (!field_push(L, 1, "world", LUA_TTABLE))
        return;
    field_only(L, -1, "world", corners);
    read_corner(L, "lower", info->dims, info->lower);
    read_corner(L, "upper", info->dims, info->upper);
    for (uint32_t i = 0; i < info->dims; ++i)
        if (info->lower[i] > info->upper[i])
            field_raise(L, "world", "world's lower is above its upper");
    info->has_world = true;
    lua_pop(L, 1);
}

static void read_cell(lua_State *L, scene_reading *reading)
{
    float cell = (float)field_number(L, 1, "cell", 0);
    if (cell < 0 || !isfinite(cell))
        field_raise(L, "cell", "cell is %g; it must be an edge above 0, or 0 for one that fits",
                    (double)cell);
    reading->scene->info.cell = cell;
}

static void read_cell_fixed(lua_State *L, scene_reading *reading)
{
    reading->scene->info.cell_fixed = field_boolean(L, 1, "cell_fixed", false);
}

static void read_level(lua_State *L, scene_reading *reading)
{
    accuracy_read_level(L, 1, &reading->scene->info.level);
}

static void read_accuracy(lua_State *L, scene_reading *reading)
{
    duet_scene_info *info = &reading->scene->info;
    info->has_accuracy = accuracy_read(L, 1, &info->accuracy);
    if (info->has_accuracy && field_string(L, 1, "level", NULL))
        field_raise(L, "accuracy", "a scene has a level, or an accuracy that one is chosen by");
}

// In this order: dims are checked against the objects, and world against dims.
static const struct {
    const char *name;
    void (*read)(lua_State *L, scene_reading *reading);
} fields[] = {
    {"name", read_name},
    {"objects", read_objects},
    {"dims", read_dims},
    {"world", read_world},
    {"cell", read_cell},
    {"cell_fixed", read_cell_fixed},
    {"level", read_level},
    {"accuracy", read_accuracy},
    {"body", scene_read_body},
    {"gravity", scene_read_gravity},
    {"origin", scene_read_origin},
    {"attraction", scene_read_attraction},
    {"boundary", scene_read_boundary},
    {"wants", scene_read_wants},
    {"integrator", scene_read_integrator},
    {"dt", scene_read_motion_numbers},
};

// Fields that others above read along with theirs.
static const char *const more_names[] = {
    "origin_edge",           "drag",        "skin",        "slop",     "max_push_speed",
    "restitution_threshold", "sleep_speed", "sleep_after", "substeps", "doubles"};

#define N_MORE (sizeof more_names / sizeof more_names[0])

#define N_FIELDS (sizeof fields / sizeof fields[0])

// Reads what the script returned. Argument 1: that, 2: the reading.
static int read_result(lua_State *L)
{
    scene_reading *reading = lua_touserdata(L, 2);
    if (!lua_istable(L, 1))
        return field_raise(L, NULL, "a scene must return a table, not %s", luaL_typename(L, 1));
    if (reading->n_settings > 0 && !reading->declared)
        return field_raise(L, NULL, "no parameter '%s'; the scene declares none",
                           reading->settings[0].name);
    const char *names[N_FIELDS + N_MORE + 1] = {NULL};
    for (size_t i = 0; i < N_FIELDS; ++i)
        names[i] = fields[i].name;
    for (size_t i = 0; i < N_MORE; ++i)
        names[N_FIELDS + i] = more_names[i];
    field_only(L, 1, "a scene", names);
    for (size_t i = 0; i < N_FIELDS; ++i)
        fields[i].read(L, reading);
    if (!scene_fill_bodies(reading->scene, reading->err))
        return luaL_error(L, "no memory");
    return 0;
}

// The scenes that come with Duet are there under their names in the source tree
// also where that is not.
static bool run_scene(script *s, const char *path, duet_error *err)
{
    const blob *carried = access(path, F_OK) == 0 ? NULL : blob_find(path);
    return carried ? script_run(s, path, carried->bytes, carried->length, 1, err)
                   : script_run_file(s, path, 1, err);
}

bool scene_read_lua(duet_scene *scene, const char *path, const duet_setting *settings,
                    uint32_t n_settings, duet_error *err)
{
    scene_reading reading = {scene, path, settings, n_settings, false, err};
    script *s = script_open(&limits, err);
    if (!s)
        return false;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, open_words);
    lua_pushlightuserdata(L, &reading);
    bool ok = script_call(s, 1, 0, err);
    lua_pushcfunction(L, read_result);
    ok = ok && run_scene(s, path, err);
    lua_pushlightuserdata(L, &reading);
    ok = ok && script_call(s, 2, 0, err);
    script_close(s);
    return ok;
}
