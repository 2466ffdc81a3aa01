// SPDX-License-Identifier: MIT
// What a script's scene says of motion: the bodies of its objects, and the motion's def.
#include "runtime/scene/scene_lua.h"

#include "base/error.h"
#include "base/list.h"
#include "gen/field.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/scene/scene_heights.h"
#include "runtime/scene/scene_mesh.h"

#include <lauxlib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- bodies

typedef enum body_kind { NUMBER, VECTOR, BITS, BOOLEAN } body_kind;

static const struct {
    const char *name;
    body_kind kind;
    size_t at;
} body_fields[] = {
    {"velocity", VECTOR, offsetof(duet_body, velocity)},
    {"angular_velocity", VECTOR, offsetof(duet_body, angular_velocity)},
    {"mass", NUMBER, offsetof(duet_body, mass)},
    {"restitution", NUMBER, offsetof(duet_body, restitution)},
    {"friction", NUMBER, offsetof(duet_body, friction)},
    {"group", BITS, offsetof(duet_body, group)},
    {"mask", BITS, offsetof(duet_body, mask)},
    {"fixed_rotation", BOOLEAN, offsetof(duet_body, fixed_rotation)},
    {"sensor", BOOLEAN, offsetof(duet_body, sensor)},
    {"rolling_resistance", NUMBER, offsetof(duet_body, rolling_resistance)},
    {"surface_velocity", VECTOR, offsetof(duet_body, surface_velocity)},
    {"material", BITS, offsetof(duet_body, material)},
};

enum { N_BODY_FIELDS = sizeof body_fields / sizeof body_fields[0] };

static size_t size_of(body_kind kind)
{
    static const size_t sizes[] = {[NUMBER] = sizeof(float),
                                   [VECTOR] = 3 * sizeof(float),
                                   [BITS] = sizeof(uint32_t),
                                   [BOOLEAN] = sizeof(bool)};
    return sizes[kind];
}

static float read_number(lua_State *L, const char *name)
{
    int is_number = 0;
    float value = (float)lua_tonumberx(L, -1, &is_number);
    if (!is_number || !isfinite(value))
        field_raise(L, name, "%s must be made of finite numbers", name);
    return value;
}

// Two or three numbers; in 2D an angular velocity is one.
static void read_vector(lua_State *L, const char *name, float v[3])
{
    bool turns = strcmp(name, "angular_velocity") == 0;
    if (turns && lua_isnumber(L, -1)) {
        v[2] = read_number(L, name);
        return;
    }
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (n != 3 && (n != 2 || turns))
        field_raise(L, name, "%s must be 2 or 3 numbers; an angular velocity in 2D is one", name);
    for (lua_Unsigned i = 0; i < n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        v[i] = read_number(L, name);
        lua_pop(L, 1);
    }
}

static void read_value(lua_State *L, int field, void *to)
{
    const char *name = body_fields[field].name;
    switch (body_fields[field].kind) {
    case NUMBER:
        *(float *)to = read_number(L, name);
        break;
    case VECTOR:
        read_vector(L, name, to);
        break;
    case BITS:
        if (!lua_isinteger(L, -1) || lua_tointeger(L, -1) < 0 || lua_tointeger(L, -1) > UINT32_MAX)
            field_raise(L, name, "%s must be a whole number below 2^32", name);
        *(uint32_t *)to = (uint32_t)lua_tointeger(L, -1);
        break;
    case BOOLEAN:
        if (!lua_isboolean(L, -1))
            field_raise(L, name, "%s must be true or false", name);
        *(bool *)to = lua_toboolean(L, -1);
        break;
    }
}

bool scene_read_body_field(lua_State *L, const char *name, scene_body *body)
{
    for (int i = 0; i < N_BODY_FIELDS; ++i) {
        if (strcmp(body_fields[i].name, name) != 0)
            continue;
        read_value(L, i, (char *)&body->body + body_fields[i].at);
        body->given |= 1u << i;
        return true;
    }
    return false;
}

bool scene_keep_body(duet_scene *scene, const scene_body *body, duet_error *err)
{
    scene_body *given = list_room(scene->given, scene->n_given, sizeof *given, err);
    if (!given)
        return false;
    scene->given = given;
    scene->given[scene->n_given] = *body;
    scene->given[scene->n_given++].id = scene->info.n - 1;
    return true;
}

bool scene_fill_bodies(duet_scene *scene, duet_error *err)
{
    if (scene->n_given == 0 && !scene->has_body)
        return true;
    scene->bodies = calloc((size_t)scene->info.n + 1, sizeof *scene->bodies);
    if (!scene->bodies)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bodies", scene->info.n);
    for (uint32_t id = 0; id < scene->info.n; ++id)
        scene->bodies[id] = scene->body;
    for (uint32_t i = 0; i < scene->n_given; ++i) {
        const scene_body *g = &scene->given[i];
        for (int f = 0; f < N_BODY_FIELDS; ++f)
            if (g->given >> f & 1u)
                memcpy((char *)&scene->bodies[g->id] + body_fields[f].at,
                       (const char *)&g->body + body_fields[f].at, size_of(body_fields[f].kind));
    }
    return true;
}

// ---------------------------------------------------------------- the scene

void scene_read_body(lua_State *L, scene_reading *reading)
{
    duet_scene *scene = reading->scene;
    if (!field_push(L, 1, "body", LUA_TTABLE))
        return;
    scene_body body = {.body = scene->body};
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        const char *name = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "?";
        if (!scene_read_body_field(L, name, &body))
            field_raise(L, "body", "body has no field '%s'; it has " SCENE_BODY_NAMES, name);
    }
    scene->body = body.body;
    scene->has_body = true;
    lua_pop(L, 1);
}

// Reads `dims` finite numbers from the top of the stack.
static void read_doubles(lua_State *L, const char *name, uint32_t dims, double *v)
{
    bool ok = lua_rawlen(L, -1) == dims;
    for (uint32_t i = 0; ok && i < dims; ++i) {
        ok = lua_rawgeti(L, -1, (lua_Integer)i + 1) == LUA_TNUMBER;
        v[i] = lua_tonumber(L, -1);
        ok = ok && isfinite(v[i]);
        lua_pop(L, 1);
    }
    if (!ok)
        field_raise(L, name, "%s must be %u finite numbers", name, dims);
}

static void read_corner(lua_State *L, scene_reading *reading, const char *name, double *v)
{
    if (!field_push(L, 1, name, LUA_TTABLE))
        return;
    read_doubles(L, name, reading->scene->info.dims, v);
    lua_pop(L, 1);
}

void scene_read_gravity(lua_State *L, scene_reading *reading)
{
    read_corner(L, reading, "gravity", reading->scene->motion.gravity);
}

void scene_read_heights(lua_State *L, scene_reading *reading)
{
    duet_scene *scene = reading->scene;
    if (!field_push(L, 1, "heights", LUA_TTABLE))
        return;
    const char *fault = heights_read(L, &scene->heights);
    if (!fault && !(scene->height_values = malloc(heights_bytes(&scene->heights))))
        fault = "no memory for values";
    if (!fault)
        fault = heights_read_values(L, &scene->heights, scene->height_values);
    if (fault)
        field_raise(L, "heights", "heights: %s", fault);
    scene->heights.heights = scene->height_values;
    scene->motion.heights = &scene->heights;
    lua_pop(L, 1);
}

void scene_read_mesh(lua_State *L, scene_reading *reading)
{
    duet_scene *scene = reading->scene;
    duet_error why = {0};
    if (!field_push(L, 1, "mesh", LUA_TTABLE))
        return;
    if (!mesh_read(L, &scene->mesh, reading->path, &why))
        field_raise(L, "mesh", "mesh: %s", why.text);
    scene->motion.mesh = &scene->mesh;
    lua_pop(L, 1);
}

void scene_read_origin(lua_State *L, scene_reading *reading)
{
    lua_getfield(L, 1, "origin");
    bool named = lua_type(L, -1) == LUA_TSTRING;
    bool cells = named && strcmp(lua_tostring(L, -1), "cell") == 0;
    lua_pop(L, 1);
    if (named && !cells)
        field_raise(L, "origin", "origin is '%s'; it must be \"cell\", or where the poses' 0 lies",
                    field_string(L, 1, "origin", NULL));
    if (!named)
        read_corner(L, reading, "origin", reading->scene->motion.origin);
    duet_error err = {0};
    if (cells &&
        !scene_set_origin(reading->scene, NULL, field_number(L, 1, "origin_edge", 1), &err)) {
        error_copy(reading->err, &err);
        luaL_error(L, "%s", err.text);
    }
}

void scene_read_attraction(lua_State *L, scene_reading *reading)
{
    static const char *const names[] = {"centre", "strength", NULL};
    duet_motion_def *def = &reading->scene->motion;
    if (!field_push(L, 1, "attraction", LUA_TTABLE))
        return;
    field_only(L, -1, "attraction", names);
    def->attraction = field_number(L, -1, "strength", 0);
    if (field_push(L, -1, "centre", LUA_TTABLE)) {
        read_doubles(L, "centre", reading->scene->info.dims, def->centre);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}

void scene_read_boundary(lua_State *L, scene_reading *reading)
{
    duet_scene *scene = reading->scene;
    const char *boundary = field_string(L, 1, "boundary", NULL);
    if (!boundary)
        return;
    bool walls = strcmp(boundary, "walls") == 0;
    if (!walls && strcmp(boundary, "periodic") != 0)
        field_raise(L, "boundary", "boundary is '%s'; expected walls or periodic", boundary);
    if (!scene->info.has_world)
        field_raise(L, "boundary", "boundary needs a world, whose sides it is about");
    scene->motion.boundary = walls ? DUET_BOUNDARY_WALLS : DUET_BOUNDARY_PERIODIC;
    for (uint32_t k = 0; k < scene->info.dims; ++k) {
        scene->motion.lower[k] = scene->info.lower[k];
        scene->motion.upper[k] = scene->info.upper[k];
    }
}

uint32_t scene_effect_named(const char *name)
{
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (strcmp(duet_effect_name(bit), name) == 0)
            return bit;
    return 0;
}

void scene_read_wants(lua_State *L, scene_reading *reading)
{
    if (!field_push(L, 1, "wants", LUA_TTABLE))
        return;
    lua_Unsigned n = lua_rawlen(L, -1);
    for (lua_Unsigned i = 1; i <= n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i);
        const char *name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "?";
        uint32_t effect = scene_effect_named(name);
        if (!effect)
            field_raise(L, "wants",
                        "wants has '%s', which is no effect; docs/effects.md lists them", name);
        reading->scene->motion.wants |= effect;
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}

const char *scene_integrator_name(int integrator)
{
    static const char *const names[] = {[DUET_INTEGRATOR_EULER] = "euler",
                                        [DUET_INTEGRATOR_VERLET] = "verlet",
                                        [DUET_INTEGRATOR_YOSHIDA] = "yoshida"};
    return integrator <= DUET_INTEGRATOR_YOSHIDA ? names[integrator] : NULL;
}

void scene_read_integrator(lua_State *L, scene_reading *reading)
{
    const char *name = field_string(L, 1, "integrator", scene_integrator_name(0));
    for (int i = 0; scene_integrator_name(i); ++i)
        if (strcmp(name, scene_integrator_name(i)) == 0) {
            reading->scene->motion.integrator = (duet_integrator)i;
            return;
        }
    field_raise(L, "integrator", "integrator is '%s'; it must be euler, verlet or yoshida", name);
}

// ---------------------------------------------------------------- for callers

const duet_body *duet_scene_get_bodies(const duet_scene *scene)
{
    return scene ? scene->bodies : NULL;
}

duet_motion_def duet_scene_motion_def(const duet_scene *scene, duet_device_pair *pair)
{
    duet_motion_def def = scene ? scene->motion : duet_default_motion_def();
    def.pair = pair;
    def.dims = scene ? scene->info.dims : def.dims;
    def.origin_edge = scene ? scene->info.origin_edge : 0.0f;
    return def;
}
