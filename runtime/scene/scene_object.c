// SPDX-License-Identifier: MIT
// One object as a scene's script writes it, made into a row.
#include "runtime/scene/scene_lua.h"

#include "base/budget.h"
#include "base/error.h"
#include "gen/sandbox.h"

#include <lauxlib.h>
#include <math.h>
#include <string.h>

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

int scene_word_euler(lua_State *L)
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

// The object that is read, in messages.
static field_table object_of(const scene_reading *reading)
{
    return (field_table){"object", (lua_Integer)reading->scene->n_read, NULL};
}

static int refuse(lua_State *L, const scene_reading *reading, const char *expected)
{
    return field_raise(L, "objects", "object %llu: %s", (unsigned long long)reading->scene->n_read,
                       expected);
}

// A number, or a list of as many as the row's range has.
static void read_part(lua_State *L, const field *f, void *at)
{
    part *p = at;
    bool is_list = lua_istable(L, -1);
    lua_Unsigned n = is_list ? lua_rawlen(L, -1) : 1;
    if (n < (lua_Unsigned)f->least || n > (lua_Unsigned)f->most)
        field_refuse(L, f, NULL);
    for (p->n = 0; p->n < n; ++p->n) {
        if (is_list)
            lua_rawgeti(L, -1, (lua_Integer)p->n + 1);
        if (lua_type(L, -1) != LUA_TNUMBER)
            field_refuse(L, f, NULL);
        p->value[p->n] = lua_tonumber(L, -1);
        lua_pop(L, is_list);
    }
}

static const field_type field_part = {.read = read_part};

// An object in parts, of which each has its numbers, and its body.
typedef struct object {
    part parts[N_PARTS];
    duet_body body;
} object;

#define PART(name, id, least_, most_, expected_)                                                \
    [id] = {FIELD_ROW(name, field_part, object, parts[id]), .least = (least_), .most = (most_), \
            .expected = (expected_)}

static const field object_fields[] = {
    PART("centre", CENTRE, 2, 3, "2 or 3 numbers"),
    PART("half_extents", HALF, 2, 3, "2 or 3 numbers"),
    PART("radius", RADIUS, 1, 1, "a number"),
    PART("rotation", ROTATION, 4, 4, "4 numbers"), // quaternion xyzw, 3D
    PART("euler", EULER, 3, 3, "3 numbers"),       // phi, theta, psi in radians, 3D
    PART("angle", ANGLE, 1, 1, "a number"),        // radians, 2D
    PART("lower", LOWER, 2, 3, "2 or 3 numbers"),  // an axis-aligned box by its corners
    PART("upper", UPPER, 2, 3, "2 or 3 numbers"),
    SCENE_BODY_FIELDS(object, body.),
    {0},
};

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
    object o = {.parts = {{.n = 0}}};
    uint64_t given = field_read_row(L, -1, object_of(reading), object_fields, &o);
    body->body = o.body;
    body->given = (uint32_t)(given >> N_PARTS);
    if (!fit_together(o.parts))
        refuse(L, reading,
               "it must have centre and half_extents or radius or both, with angle in 2D, rotation "
               "or euler in 3D; or lower and upper");
    return join_parts(o.parts);
}

// The table on top of the stack, {1, 2, 3, ...}; named fields beside the
// numbers are refused, not passed over.
static row read_list(lua_State *L, const scene_reading *reading)
{
    if (!is_list(L))
        refuse(L, reading, "it must be a row of numbers, or named fields, not both");
    row r = {.n = (uint32_t)lua_rawlen(L, -1)};
    for (uint32_t i = 0; i < r.n && i < SCENE_MAX_COLUMNS; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        if (lua_type(L, -1) != LUA_TNUMBER)
            refuse(L, reading, "a number is wanted where something else is");
        r.value[i] = lua_tonumber(L, -1);
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
        refuse(L, reading, "it must be a table");
    bool is_list = lua_rawlen(L, -1) > 0;
    scene_body body = {.given = 0};
    row r = is_list ? read_list(L, reading) : read_parts(L, reading, &body);
    uint32_t kept = reading->scene->info.n;
    add_row(L, reading, &r);
    if (body.given && reading->scene->info.n > kept &&
        !scene_keep_body(reading->scene, &body, reading->err))
        script_lacks_memory(L);
}

int scene_word_add(lua_State *L)
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

void scene_read_objects(lua_State *L, const field *f, void *scene)
{
    (void)scene;
    if (!lua_istable(L, -1) || !is_list(L))
        field_refuse(L, f, "a list");
    lua_Unsigned n = lua_rawlen(L, -1);
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        add_table(L, scene_reading_of(L));
        lua_pop(L, 1);
    }
}
