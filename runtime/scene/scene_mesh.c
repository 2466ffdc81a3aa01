// SPDX-License-Identifier: MIT
// A ground of triangles as a Lua table:
// { file = "drum.stl", scale = 0.001, origin = { 0, 0, 0 }, material = 1 }
// { vertices = { x, y, z, ... }, triangles = { 0, 1, 2, ... } }
#include "runtime/scene/scene_mesh.h"

#include "base/error.h"
#include "base/text.h"
#include "runtime/scene/mesh_file.h"
#include "runtime/scene/scene_ground.h"

#include <lauxlib.h>
#include <stdlib.h>
#include <string.h>

static bool refuse(duet_error *err, const char *fault)
{
    return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s", fault);
}

static bool is_given(lua_State *L, const char *name)
{
    bool given = lua_getfield(L, -1, name) != LUA_TNIL;
    lua_pop(L, 1);
    return given;
}

// ---------------------------------------------------------------- files

// A file's name leads nowhere but to the scene's folder and below it.
static bool is_below(const char *name)
{
    return name[0] != '\0' && name[0] != '/' && strcmp(name, "..") != 0 &&
           strncmp(name, "../", 3) != 0 && !strstr(name, "/../");
}

static bool read_file(lua_State *L, duet_mesh *mesh, const char *beside, duet_error *err)
{
    double scale = 1.0;
    const char *slash = beside ? strrchr(beside, '/') : NULL;
    bool is_name = lua_getfield(L, -1, "file") == LUA_TSTRING;
    const char *name = is_name ? lua_tostring(L, -1) : "";
    lua_pop(L, 1); // the table keeps it
    if (!is_name || (beside && !is_below(name)))
        return refuse(err, "file must be the name of a file .stl or .obj in the scene's folder or "
                           "below it");
    if (!ground_read_numbers(L, "scale", &scale, 1) || !(scale > 0.0))
        return refuse(err, "scale must be a number above 0");
    text path = {0};
    text_add_bytes(&path, beside, slash ? (size_t)(slash - beside) + 1 : 0);
    text_add(&path, "%s", name);
    bool ok = text_ok(&path, err) && mesh_file_read(mesh, text_chars(&path), scale, err);
    text_free(&path);
    return ok;
}

// ---------------------------------------------------------------- lists

// Sets how many rows of three numbers a list has.
static bool count_rows(lua_State *L, const char *name, uint64_t most, uint32_t *n)
{
    lua_Unsigned length = 0;
    if (lua_getfield(L, -1, name) == LUA_TTABLE)
        length = lua_rawlen(L, -1);
    lua_pop(L, 1);
    *n = (uint32_t)(length / 3);
    return length > 0 && length % 3 == 0 && length / 3 <= most;
}

static bool read_vertices(lua_State *L, float *to, uint32_t n)
{
    bool ok = true;
    lua_getfield(L, -1, "vertices");
    for (uint32_t i = 0; ok && i < 3 * n; ++i) {
        ok = lua_rawgeti(L, -1, (lua_Integer)i + 1) == LUA_TNUMBER;
        to[i] = (float)lua_tonumber(L, -1);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return ok;
}

static bool read_triangles(lua_State *L, uint32_t *to, uint32_t n)
{
    bool ok = true;
    lua_getfield(L, -1, "triangles");
    for (uint32_t i = 0; ok && i < 3 * n; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        lua_Integer vertex = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : -1;
        ok = vertex >= 0 && vertex < UINT32_MAX;
        to[i] = (uint32_t)vertex;
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return ok;
}

static bool read_lists(lua_State *L, duet_mesh *mesh, duet_error *err)
{
    if (!count_rows(L, "vertices", 3 * (uint64_t)DUET_MOST_TRIANGLES, &mesh->n_vertices))
        return refuse(err, "vertices must be a list of numbers, three a vertex");
    if (!count_rows(L, "triangles", DUET_MOST_TRIANGLES, &mesh->n_triangles))
        return refuse(err, "triangles must be a list of numbers of vertices, three a triangle");
    float *vertices = malloc((size_t)mesh->n_vertices * 3 * sizeof *vertices);
    uint32_t *triangles = malloc((size_t)mesh->n_triangles * 3 * sizeof *triangles);
    mesh->vertices = vertices;
    mesh->triangles = triangles;
    if (!vertices || !triangles)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u triangles",
                         mesh->n_triangles);
    if (!read_vertices(L, vertices, mesh->n_vertices))
        return refuse(err, "vertices must be numbers");
    return read_triangles(L, triangles, mesh->n_triangles) ||
           refuse(err, "triangles must be whole numbers from 0 on");
}

// ---------------------------------------------------------------- both

bool mesh_read(lua_State *L, duet_mesh *mesh, const char *beside, duet_error *err)
{
    static const char *const names[] = {"file",   "scale",    "vertices", "triangles",
                                        "origin", "material", "carrier",  NULL};
    *mesh = (duet_mesh){0};
    if (!ground_has_only(L, names))
        return refuse(err, "the fields are file and scale, or vertices and triangles; origin, "
                           "material and carrier");
    bool has_lists = is_given(L, "vertices") || is_given(L, "triangles") || !is_given(L, "file");
    if (has_lists && (is_given(L, "file") || is_given(L, "scale")))
        return refuse(err, "a mesh has a file and its scale, or vertices and triangles");
    if (!(has_lists ? read_lists(L, mesh, err) : read_file(L, mesh, beside, err)))
        return false;
    if (!ground_read_origin(L, mesh->origin))
        return refuse(err, "origin must be three numbers");
    if (!ground_read_material(L, &mesh->material))
        return refuse(err, "material must be the number of one of the materials");
    return ground_read_carrier(L, &mesh->carrier) ||
           refuse(err, "carrier must be the id of a body");
}
