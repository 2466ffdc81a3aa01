// SPDX-License-Identifier: MIT
// What a script's scene says of motion: the bodies of its objects, and the motion's def.
#include "runtime/scene/scene_lua.h"

#include "base/error.h"
#include "base/list.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/scene/scene_fields.h"
#include "runtime/scene/scene_heights.h"
#include "runtime/scene/scene_mesh.h"

#include <float.h>
#include <lauxlib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- bodies

static const field body_fields[] = {SCENE_BODY_FIELDS(duet_body, ), {0}};

static void read_angular_velocity(lua_State *L, const field *f, void *at)
{
    float *v = at;
    const bool about_z = !lua_istable(L, -1);
    field finite = *f;
    finite.size = about_z ? sizeof *v : f->size;
    finite.least = -FLT_MAX;
    finite.most = FLT_MAX;
    if (!about_z && lua_rawlen(L, -1) != 3)
        field_refuse(L, f, "{ x, y, z } or, in 2D, a number");
    field_float.read(L, &finite, about_z ? &v[2] : v);
}

const field_type field_angular_velocity = {.read = read_angular_velocity};

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
        return no_memory(err, "%u bodies", scene->info.n);
    for (uint32_t id = 0; id < scene->info.n; ++id)
        scene->bodies[id] = scene->body;
    for (uint32_t i = 0; i < scene->n_given; ++i) {
        const scene_body *g = &scene->given[i];
        for (const field *f = body_fields; f->name; ++f)
            if (g->given >> (f - body_fields) & 1u)
                memcpy((char *)&scene->bodies[g->id] + f->offset,
                       (const char *)&g->body + f->offset, f->size);
    }
    return true;
}

// ---------------------------------------------------------------- the scene

scene_reading *scene_reading_of(lua_State *L)
{
    return lua_touserdata(L, 2);
}

void scene_read_body(lua_State *L, const field *f, void *at)
{
    duet_scene *scene = at;
    (void)f;
    field_read_row(L, -1, (field_table){"body", -1, NULL}, body_fields, &scene->body);
    scene->has_body = true;
}

void scene_read_by_dims(lua_State *L, const field *f, double to[3])
{
    uint32_t dims = scene_reading_of(L)->scene->info.dims;
    bool ok = lua_istable(L, -1) && lua_rawlen(L, -1) == dims;
    for (uint32_t i = 0; ok && i < dims; ++i) {
        ok = lua_rawgeti(L, -1, (lua_Integer)i + 1) == LUA_TNUMBER;
        to[i] = lua_tonumber(L, -1);
        ok = ok && isfinite(to[i]);
        lua_pop(L, 1);
    }
    if (!ok)
        field_refuse(L, f, dims == 2 ? "2 finite numbers" : "3 finite numbers");
}

void scene_read_gravity(lua_State *L, const field *f, void *at)
{
    scene_read_by_dims(L, f, ((duet_scene *)at)->motion.gravity);
}

void scene_read_heights(lua_State *L, const field *f, void *at)
{
    duet_scene *scene = at;
    (void)f;
    heights_read(L, &scene->heights);
    scene->height_values = malloc(heights_bytes(&scene->heights));
    if (!scene->height_values)
        luaL_error(L, "heights: no memory for values");
    heights_read_values(L, &scene->heights, scene->height_values);
    scene->heights.heights = scene->height_values;
    scene->motion.heights = &scene->heights;
}

void scene_read_mesh(lua_State *L, const field *f, void *at)
{
    duet_scene *scene = at;
    (void)f;
    mesh_read(L, &scene->mesh, scene_reading_of(L)->path);
    scene->motion.mesh = &scene->mesh;
}

void scene_read_origin_edge(lua_State *L, const field *f, void *at)
{
    field one = *f;
    one.size = sizeof(double);
    one.least = -DBL_MAX;
    one.most = DBL_MAX;
    (void)at;
    field_double.read(L, &one, &scene_reading_of(L)->origin_edge);
}

void scene_read_origin(lua_State *L, const field *f, void *at)
{
    duet_scene *scene = at;
    scene_reading *reading = scene_reading_of(L);
    duet_error err = {0};
    if (lua_istable(L, -1)) {
        scene_read_by_dims(L, f, scene->motion.origin);
        return;
    }
    if (lua_type(L, -1) != LUA_TSTRING || strcmp(lua_tostring(L, -1), "cell") != 0)
        field_refuse(L, f, "\"cell\", or where the poses' 0 lies");
    if (!scene_set_origin(scene, NULL, reading->origin_edge, &err)) {
        error_copy(reading->err, &err);
        luaL_error(L, "%s", err.text);
    }
}

static void read_centre(lua_State *L, const field *f, void *at)
{
    scene_read_by_dims(L, f, at);
}

static const field attraction_fields[] = {
    {FIELD_ROW("strength", field_double, duet_motion_def, attraction), .least = -DBL_MAX,
     .most = DBL_MAX},
    FIELD(((const field_type){.read = read_centre}), duet_motion_def, centre),
    {0},
};

void scene_read_attraction(lua_State *L, const field *f, void *at)
{
    (void)f;
    field_read_row(L, -1, (field_table){"attraction", -1, NULL}, attraction_fields,
                   &((duet_scene *)at)->motion);
}

void scene_read_boundary(lua_State *L, const field *f, void *at)
{
    duet_scene *scene = at;
    field boundary = *f;
    boundary.name_of = scene_boundary_name;
    field_enum.read(L, &boundary, &scene->motion.boundary);
    if (scene->motion.boundary == DUET_BOUNDARY_NONE)
        return;
    if (!scene->info.has_world)
        field_raise(L, "boundary", "boundary needs a world, whose sides it is about");
    for (uint32_t k = 0; k < scene->info.dims; ++k) {
        scene->motion.lower[k] = scene->info.lower[k];
        scene->motion.upper[k] = scene->info.upper[k];
    }
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
