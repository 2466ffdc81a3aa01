// SPDX-License-Identifier: MIT
// A scene as a Lua file: it adds objects while it runs, and returns a table
// with what else there is to say.
#include "runtime/scene/scene_lua.h"

#include "base/budget.h"
#include "base/error.h"
#include "base/rng.h"
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

// ---------------------------------------------------------------- random
// Random numbers for scenes: rng.h's, so that a scene is the same on every
// machine. They draw from a source that the script seeds; two sources are
// independent of each other.

#define TURN 6.283185307179586476925

static rng *source_of(lua_State *L)
{
    return lua_touserdata(L, lua_upvalueindex(1));
}

// uniform(from, to): from 0 to 1 where they are left out
static int draw_uniform(lua_State *L)
{
    double from = luaL_optnumber(L, 1, 0);
    double to = luaL_optnumber(L, 2, 1);
    lua_pushnumber(L, rng_between(source_of(L), from, to));
    return 1;
}

// integer(from, to): both may be drawn
static int draw_integer(lua_State *L)
{
    lua_Integer from = luaL_checkinteger(L, 1);
    lua_Integer to = luaL_checkinteger(L, 2);
    luaL_argcheck(L, from <= to, 2, "must not be below the first");
    lua_Unsigned span = (lua_Unsigned)to - (lua_Unsigned)from;
    luaL_argcheck(L, span < UINT32_MAX, 2, "must be less than 2^32-1 above the first");
    lua_pushinteger(L, from + (lua_Integer)rng_below(source_of(L), (uint32_t)span + 1));
    return 1;
}

// normal(mean, deviation): 0 and 1 where they are left out
static int draw_normal(lua_State *L)
{
    double mean = luaL_optnumber(L, 1, 0);
    double deviation = luaL_optnumber(L, 2, 1);
    lua_pushnumber(L, mean + deviation * rng_normal(source_of(L)));
    return 1;
}

// angle(): radians, a whole turn
static int draw_angle(lua_State *L)
{
    lua_pushnumber(L, rng_between(source_of(L), 0, TURN));
    return 1;
}

// A point in the unit disk, which is not its centre; returns its distance from
// there, squared.
static double draw_in_disk(rng *source, double point[2])
{
    for (;;) {
        point[0] = rng_between(source, -1, 1);
        point[1] = rng_between(source, -1, 1);
        double squared = point[0] * point[0] + point[1] * point[1];
        if (squared > 0 && squared < 1)
            return squared;
    }
}

// quaternion() -> x, y, z, w: all rotations are equally likely (Marsaglia
// 1972). It takes no sine, which would be another one on another machine.
static int draw_quaternion(lua_State *L)
{
    double a[2];
    double b[2];
    double a_squared = draw_in_disk(source_of(L), a);
    double scale = sqrt((1 - a_squared) / draw_in_disk(source_of(L), b));
    lua_pushnumber(L, a[0]);
    lua_pushnumber(L, a[1]);
    lua_pushnumber(L, b[0] * scale);
    lua_pushnumber(L, b[1] * scale);
    return 4;
}

// Pushes a table of functions that draw from one source, which is returned.
static rng *push_random(lua_State *L)
{
    static const luaL_Reg draws[] = {
        {"uniform", draw_uniform}, {"integer", draw_integer},       {"normal", draw_normal},
        {"angle", draw_angle},     {"quaternion", draw_quaternion}, {NULL, NULL},
    };
    luaL_newlibtable(L, draws);
    rng *source = lua_newuserdatauv(L, sizeof *source, 0);
    *source = rng_seed(0);
    luaL_setfuncs(L, draws, 1);
    return source;
}

// random(seed)
static int word_random(lua_State *L)
{
    uint64_t seed = (uint64_t)luaL_checkinteger(L, 1);
    *push_random(L) = rng_seed(seed);
    return 1;
}

// ---------------------------------------------------------------- objects
// One object as a scene's script writes it, made into a row.

// Instructions that a script pays for an object, so that an endless loop ends before memory does.
#define ADD_INSTRUCTIONS 20

// The named parts that an object can have, and how many numbers each takes.
typedef enum part_id {
    CENTRE,
    HALF,
    RADIUS,
    ROTATION,
    EULER,
    ANGLE,
    LOWER,
    UPPER,
    N_PARTS
} part_id;

static const struct {
    const char *name;
    uint32_t least;
    uint32_t most;
    const char *count; // both in words
} parts[N_PARTS] = {
    [CENTRE] = {"centre", 2, 3, "2 or 3"},     // xyz
    [HALF] = {"half_extents", 2, 3, "2 or 3"}, // half extents
    [RADIUS] = {"radius", 1, 1, "1"},          // of a rounded box
    [ROTATION] = {"rotation", 4, 4, "4"},      // quaternion xyzw, 3D
    [EULER] = {"euler", 3, 3, "3"},            // phi, theta, psi in radians, 3D
    [ANGLE] = {"angle", 1, 1, "1"},            // radians, 2D
    [LOWER] = {"lower", 2, 3, "2 or 3"},       // an axis-aligned box by its corners
    [UPPER] = {"upper", 2, 3, "2 or 3"},
};

#define MAX_PART 4

typedef struct part {
    double value[MAX_PART];
    uint32_t n; // 0: not given
} part;

typedef struct row {
    double value[SCENE_MAX_COLUMNS];
    uint32_t n;
} row;

// --------------------------------------------------------------- rotations

// R = Rx(phi) Ry(theta) Rz(psi), as figure 4 of the paper has it: the product
// of the three quaternions in that order, whatever the angles are.
static void euler_to_quaternion(const double angle[3], double q[4])
{
    double s[3];
    double c[3];
    for (int i = 0; i < 3; ++i) {
        s[i] = sin(angle[i] / 2);
        c[i] = cos(angle[i] / 2);
    }
    q[0] = s[0] * c[1] * c[2] + c[0] * s[1] * s[2];
    q[1] = c[0] * s[1] * c[2] - s[0] * c[1] * s[2];
    q[2] = c[0] * c[1] * s[2] + s[0] * s[1] * c[2];
    q[3] = c[0] * c[1] * c[2] - s[0] * s[1] * s[2];
}

// euler(phi, theta, psi) -> x, y, z, w
static int word_euler(lua_State *L)
{
    const double angle[3] = {luaL_checknumber(L, 1), luaL_checknumber(L, 2),
                             luaL_checknumber(L, 3)};
    double q[4];
    euler_to_quaternion(angle, q);
    for (int i = 0; i < 4; ++i)
        lua_pushnumber(L, q[i]);
    return 4;
}

// ------------------------------------------------------------------- parts

static bool is_list(lua_State *L)
{
    lua_Unsigned n = 0;
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1))
        ++n;
    return n == lua_rawlen(L, -1);
}

// Raises the error at the line that calls add, or for an object of a list at
// the field's.
static int refuse(lua_State *L, const scene_reading *reading, const char *field, const char *what)
{
    lua_Debug caller;
    if (lua_getstack(L, 1, &caller))
        return luaL_error(L, "object %I: %s", (LUAI_UACINT)reading->scene->n_read, what);
    return field_raise(L, field, "object %llu: %s", (unsigned long long)reading->scene->n_read,
                       what);
}

static double read_number(lua_State *L, const scene_reading *reading, const char *field)
{
    if (lua_type(L, -1) != LUA_TNUMBER)
        refuse(L, reading, field, "a number is wanted where something else is");
    return lua_tonumber(L, -1);
}

static part_id find_part(lua_State *L, const scene_reading *reading, const char *name)
{
    for (int id = 0; id < N_PARTS; ++id)
        if (strcmp(parts[id].name, name) == 0)
            return (part_id)id;
    const char *what =
        lua_pushfstring(L,
                        "no field '%s'; it has angle, centre, euler, half_extents, lower, "
                        "radius, rotation, upper; " SCENE_BODY_NAMES,
                        name);
    refuse(L, reading, name, what);
    return N_PARTS;
}

// The value on top of the stack: a number, or a list of them.
static part read_part(lua_State *L, const scene_reading *reading, part_id id)
{
    const char *name = parts[id].name;
    bool is_list = lua_istable(L, -1);
    part p = {.n = is_list ? (uint32_t)lua_rawlen(L, -1) : 1};
    if (p.n < parts[id].least || p.n > parts[id].most)
        refuse(L, reading, name,
               lua_pushfstring(L, "%s has %d numbers; it must have %s", name, (int)p.n,
                               parts[id].count));
    if (!is_list)
        p.value[0] = read_number(L, reading, name);
    for (uint32_t i = 0; is_list && i < p.n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        p.value[i] = read_number(L, reading, name);
        lua_pop(L, 1);
    }
    return p;
}

// Bounds are two corners; a pose is centre and half extents, and a rotation of the kind that its
// dimensions have. An object with a radius may have no extents besides.
static bool fit_together(const part *p)
{
    bool corners = p[LOWER].n > 0 && p[LOWER].n == p[UPPER].n;
    bool sphere = p[RADIUS].n > 0 && p[HALF].n == 0;
    bool pose = p[CENTRE].n > 0 && (p[CENTRE].n == p[HALF].n || sphere);
    uint32_t rotations = (p[ROTATION].n > 0) + (p[EULER].n > 0);
    uint32_t angles = p[ANGLE].n > 0;
    if (corners)
        return !p[CENTRE].n && !p[HALF].n && !p[RADIUS].n && rotations + angles == 0;
    if (!pose || p[LOWER].n || p[UPPER].n)
        return false;
    return p[CENTRE].n == 2 ? rotations == 0 : rotations <= 1 && angles == 0;
}

static void append(row *r, const double *values, uint32_t n)
{
    memcpy(r->value + r->n, values, n * sizeof *values);
    r->n += n;
}

static row join_parts(const part *p)
{
    row r = {.n = 0};
    double rotation[4] = {0, 0, 0, 1};
    if (p[ROTATION].n > 0)
        memcpy(rotation, p[ROTATION].value, sizeof rotation);
    if (p[EULER].n > 0)
        euler_to_quaternion(p[EULER].value, rotation);
    append(&r, p[LOWER].value, p[LOWER].n);
    append(&r, p[UPPER].value, p[UPPER].n);
    append(&r, p[CENTRE].value, p[CENTRE].n);
    append(&r, p[HALF].value, p[CENTRE].n);
    if (p[CENTRE].n == 2 && p[RADIUS].n > 0)
        append(&r, (double[]){sin(p[ANGLE].value[0] / 2), cos(p[ANGLE].value[0] / 2)}, 2);
    else if (p[CENTRE].n == 2)
        append(&r, p[ANGLE].value, 1);
    if (p[CENTRE].n == 3)
        append(&r, rotation, 4);
    append(&r, p[RADIUS].value, p[RADIUS].n);
    return r;
}

// The table on top of the stack, {centre = {...}, half_extents = {...}, ...}.
static row read_parts(lua_State *L, const scene_reading *reading, scene_body *body)
{
    part given[N_PARTS] = {{.n = 0}};
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        const char *name = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "?";
        if (scene_read_body_field(L, name, body))
            continue;
        part_id id = find_part(L, reading, name);
        given[id] = read_part(L, reading, id);
    }
    if (!fit_together(given))
        refuse(
            L, reading, NULL,
            "it must have centre and half_extents or radius or both, with angle in 2D, rotation or "
            "euler in 3D; or lower and upper");
    return join_parts(given);
}

// The table on top of the stack, {1, 2, 3, ...}; named fields beside the
// numbers are refused, not passed over.
static row read_list(lua_State *L, const scene_reading *reading)
{
    if (!is_list(L))
        refuse(L, reading, NULL, "it must be a row of numbers, or named fields, not both");
    row r = {.n = (uint32_t)lua_rawlen(L, -1)};
    for (uint32_t i = 0; i < r.n && i < SCENE_MAX_COLUMNS; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        r.value[i] = read_number(L, reading, NULL);
        lua_pop(L, 1);
    }
    return r;
}

// -------------------------------------------------------------------- rows

// The script's line, where it is running.
static scene_place place_of(lua_State *L, const scene_reading *reading)
{
    lua_Debug frame;
    bool runs = lua_getstack(L, 1, &frame) && lua_getinfo(L, "l", &frame);
    uint64_t line = runs && frame.currentline > 0 ? (uint64_t)frame.currentline : 0;
    return (scene_place){.path = reading->path, .line = line};
}

// Objects between two words on how far the script is.
enum { OBJECTS_AT_ONCE = 1 << 12 };

static void add_row(lua_State *L, scene_reading *reading, const row *r)
{
    duet_error err = {0};
    scene_place place = place_of(L, reading);
    if (reading->scene->n_read % OBJECTS_AT_ONCE == 0)
        budget_tell(reading->scene->n_read, reading->expected);
    if (scene_set_columns(reading->scene, r->n, place, &err) &&
        scene_add_row(reading->scene, r->value, place, &err))
        return;
    error_copy(reading->err, &err);
    luaL_error(L, "%s", err.text);
}

// Adds the object on top of the stack, a table: a row of numbers or named parts.
static void add_table(lua_State *L, scene_reading *reading)
{
    script_spend(L, ADD_INSTRUCTIONS);
    if (!lua_istable(L, -1))
        refuse(L, reading, NULL, "it must be a table");
    bool is_list = lua_rawlen(L, -1) > 0;
    scene_body body = {.given = 0};
    row r = is_list ? read_list(L, reading) : read_parts(L, reading, &body);
    uint32_t kept = reading->scene->info.n;
    add_row(L, reading, &r);
    if (body.given && reading->scene->info.n > kept &&
        !scene_keep_body(reading->scene, &body, reading->err))
        luaL_error(L, "object %d: no memory", (int)reading->scene->info.n);
}

// add(row of numbers) and add{named parts}; upvalue 1 is the reading.
static int word_add(lua_State *L)
{
    scene_reading *reading = lua_touserdata(L, lua_upvalueindex(1));
    int n = lua_gettop(L);
    if (n == 1) {
        add_table(L, reading);
        return 0;
    }
    script_spend(L, ADD_INSTRUCTIONS);
    row r = {.n = (uint32_t)n};
    for (int i = 0; i < n && i < SCENE_MAX_COLUMNS; ++i)
        r.value[i] = luaL_checknumber(L, i + 1);
    add_row(L, reading, &r);
    return 0;
}

// ---------------------------------------------------------------- each
// Objects that do not know of each other: whoever wants a range of a scene makes
// no more than that.

// Calls the function at 2 with i and the table of draws at 3.
static void make_one(lua_State *L, const duet_scene *scene, lua_Integer i)
{
    uint64_t before = scene->n_read;
    lua_pushvalue(L, 2);
    lua_pushinteger(L, i);
    lua_pushvalue(L, 3);
    lua_call(L, 2, 0);
    if (scene->n_read != before + 1)
        luaL_error(L, "each: %I objects were added for i = %I; expected 1",
                   (LUAI_UACINT)(scene->n_read - before), (LUAI_UACINT)i);
}

// each(n, function(i, random) ... end); upvalue 1 is the reading.
static int word_each(lua_State *L)
{
    scene_reading *reading = lua_touserdata(L, lua_upvalueindex(1));
    duet_scene *scene = reading->scene;
    lua_Integer n = luaL_checkinteger(L, 1);
    luaL_argcheck(L, n >= 0 && n < (lua_Integer)1 << 62, 1, "expected 0 or more, below 2^62");
    luaL_checktype(L, 2, LUA_TFUNCTION);
    if (reading->in_each)
        return luaL_error(L, "each: called by the function of another each");
    lua_settop(L, 2);
    rng *source = push_random(L);
    uint64_t seed = rng_stream(reading->seed, reading->n_each++).state;
    reading->in_each = true;
    for (lua_Integer i = 1; i <= n; ++i) {
        // The first tells what kind of objects they are, kept or not.
        if (scene->columns != 0)
            i += (lua_Integer)scene_pass_over(scene, (uint64_t)(n - i + 1));
        if (i > n)
            break;
        if (scene->defers && i > 1) {
            scene->n_read += (uint64_t)(n - i + 1);
            scene->n_deferred += (uint64_t)(n - i + 1);
            break;
        }
        *source = rng_stream(seed, (uint64_t)i);
        make_one(L, scene, i);
    }
    reading->in_each = false;
    return 0;
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
    {"add", word_add},
    {"each", word_each},
    {"euler", word_euler},
    {"random", word_random},
    {"parameters", word_parameters},
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
    if (!is_list(L))
        field_raise(L, "objects", "objects must be a list");
    lua_Unsigned n = lua_rawlen(L, -1);
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        add_table(L, reading);
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
    {"heights", scene_read_heights},
    {"mesh", scene_read_mesh},
    {"origin", scene_read_origin},
    {"attraction", scene_read_attraction},
    {"boundary", scene_read_boundary},
    {"wants", scene_read_wants},
    {"integrator", scene_read_integrator},
    {"materials", scene_read_materials},
    {"dt", scene_read_motion_numbers},
};

// Fields that others above read along with theirs.
static const char *const more_names[] = {"origin_edge",   "drag",           "skin",
                                         "slop",          "max_push_speed", "restitution_threshold",
                                         "sleep_speed",   "sleep_after",    "substeps",
                                         "doubles",       "hit_speed",      "event_mask",
                                         "material_pairs"};

#define N_MORE (sizeof more_names / sizeof more_names[0])

#define N_FIELDS (sizeof fields / sizeof fields[0])

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
