// SPDX-License-Identifier: MIT
// A scene as a Lua file: it adds objects while it runs, and returns a table
// with what else there is to say.
#include "runtime/scene/scene_lua.h"

#include "base/error.h"
#include "gen/field.h"
#include "gen/parameters.h"
#include "gen/sandbox.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/scene/scene_source.h"

#include <lauxlib.h>
#include <math.h>
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

// Each reads one field of the scene's table, which is at index 1.
static void read_name(lua_State *L, scene_reading *reading)
{
    const char *name = field_string(L, 1, "name", NULL);
    if (name && !scene_set_name(reading->scene, name, strlen(name), reading->err))
        luaL_error(L, "name: no memory");
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

// A field that is a bool, a double from 0 on, or a uint32_t.
typedef enum field_kind { OTHER, FLAG, NUMBER, COUNT } field_kind;

#define FIELD(k, member) .kind = k, .at = offsetof(duet_scene, member)

// The fields of a scene, in the order in which they are read: dims are checked against the objects,
// and world against dims.
static const struct {
    const char *name;
    void (*read)(lua_State *L, scene_reading *reading); // NULL: a number, or read with another
    field_kind kind;
    size_t at; // in duet_scene
    int64_t most;
    const char *expected; // if a COUNT is another
} fields[] = {
    {"name", .read = read_name},
    {"objects", .read = scene_read_objects},
    {"dims", .read = read_dims},
    {"world", .read = read_world},
    {"cell", .read = read_cell},
    {"cell_fixed", FIELD(FLAG, info.cell_fixed)},
    {"level", .read = read_level},
    {"accuracy", .read = read_accuracy},
    {"body", .read = scene_read_body},
    {"gravity", .read = scene_read_gravity},
    {"heights", .read = scene_read_heights},
    {"mesh", .read = scene_read_mesh},
    {"origin", .read = scene_read_origin},
    {.name = "origin_edge"},
    {"attraction", .read = scene_read_attraction},
    {"boundary", .read = scene_read_boundary},
    {"wants", .read = scene_read_wants},
    {"integrator", .read = scene_read_integrator},
    {"materials", .read = scene_read_materials},
    {.name = "material_pairs"},
    {"drag", FIELD(NUMBER, motion.drag)},
    {"dt", FIELD(NUMBER, motion.dt)},
    {"skin", FIELD(NUMBER, motion.skin)},
    {"slop", FIELD(NUMBER, motion.slop)},
    {"max_push_speed", FIELD(NUMBER, motion.max_push_speed)},
    {"restitution_threshold", FIELD(NUMBER, motion.restitution_threshold)},
    {"sleep_speed", FIELD(NUMBER, motion.sleep_speed)},
    {"sleep_after", FIELD(NUMBER, motion.sleep_after)},
    {"hit_speed", FIELD(NUMBER, motion.hit_speed)},
    {"substeps", FIELD(COUNT, motion.substeps), .most = 1000,
     .expected = "0 (chosen for the scene), or 1 to 1000"},
    {"event_mask", FIELD(COUNT, motion.event_mask), .most = UINT32_MAX,
     .expected = "a whole number below 2^32"},
    {"doubles", FIELD(FLAG, motion.doubles)},
};

enum { FIELDS = sizeof fields / sizeof fields[0] };

static void read_number(lua_State *L, const char *name, double *to)
{
    *to = field_number(L, 1, name, *to);
    if (*to < 0)
        field_raise(L, name, "%s is %g; it must be 0 or above", name, *to);
}

static void read_count(lua_State *L, int field, uint32_t *to)
{
    const char *name = fields[field].name;
    int64_t n = field_integer(L, 1, name, *to);
    if (n < 0 || n > fields[field].most)
        field_raise(L, name, "%s is %lld; it must be %s", name, (long long)n,
                    fields[field].expected);
    *to = (uint32_t)n;
}

static void read_field(lua_State *L, scene_reading *reading, int field)
{
    const char *name = fields[field].name;
    void *to = (char *)reading->scene + fields[field].at;
    if (fields[field].read)
        fields[field].read(L, reading);
    else if (fields[field].kind == FLAG)
        *(bool *)to = field_boolean(L, 1, name, false);
    else if (fields[field].kind == NUMBER)
        read_number(L, name, to);
    else if (fields[field].kind == COUNT)
        read_count(L, field, to);
}

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
    const char *names[FIELDS + 1] = {NULL};
    for (int i = 0; i < FIELDS; ++i)
        names[i] = fields[i].name;
    field_only(L, 1, "a scene", names);
    for (int i = 0; i < FIELDS; ++i)
        read_field(L, reading, i);
    if (!scene_fill_bodies(reading->scene, reading->err))
        return luaL_error(L, "no memory");
    return 0;
}

bool scene_read_lua(duet_scene *scene, const scene_source *source, const duet_setting *settings,
                    uint32_t n_settings, duet_error *err)
{
    scene_reading reading = {.scene = scene,
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
