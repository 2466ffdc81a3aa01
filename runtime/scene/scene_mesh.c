// SPDX-License-Identifier: MIT
// A ground of triangles as a Lua table:
// { file = "drum.stl", scale = 0.001, origin = { 0, 0, 0 }, material = 1 }
// { vertices = { x, y, z, ... }, triangles = { 0, 1, 2, ... } }
#include "runtime/scene/scene_mesh.h"

#include "base/error.h"
#include "base/text.h"
#include "runtime/scene/mesh_file.h"
#include "runtime/scene/scene_ground.h"

#include <float.h>
#include <lauxlib.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- files

// A file's name leads nowhere but to the scene's folder and below it.
static bool is_below(const char *name)
{
    return name[0] != '\0' && name[0] != '/' && strcmp(name, "..") != 0 &&
           strncmp(name, "../", 3) != 0 && !strstr(name, "/../");
}

// Sets the vertices and triangles of the mesh, also after a failure.
static bool load(duet_mesh *mesh, const char *name, double scale, const char *beside,
                 duet_error *err)
{
    duet_mesh read = {0};
    const char *slash = beside ? strrchr(beside, '/') : NULL;
    text path = {0};
    text_add_bytes(&path, beside, slash ? (size_t)(slash - beside) + 1 : 0);
    text_add(&path, "%s", name);
    bool ok = text_ok(&path, err) && mesh_file_read(&read, text_chars(&path), scale, err);
    text_free(&path);
    mesh->n_vertices = read.n_vertices;
    mesh->n_triangles = read.n_triangles;
    mesh->vertices = read.vertices;
    mesh->triangles = read.triangles;
    return ok;
}

#define A_FILE "the name of a file .stl or .obj in the scene's folder or below it"

static const field_table table = {"mesh", -1, NULL};
static const field file_field = {
    .name = "file", .type = &field_string, .expected = A_FILE, .table = &table};
static const field scale_field = {.name = "scale",
                                  .type = &field_double,
                                  .size = sizeof(double),
                                  .least = DBL_MIN,
                                  .most = DBL_MAX,
                                  .expected = "a number above 0",
                                  .table = &table};

// ---------------------------------------------------------------- lists

// Space for the list on top of the stack, of rows of three numbers.
static void *make_rows(lua_State *L, const field *f, uint64_t most, uint32_t *n, size_t bytes)
{
    lua_Unsigned length = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    if (length == 0 || length % 3 != 0 || length / 3 > most)
        field_refuse(L, f, NULL);
    *n = (uint32_t)(length / 3);
    void *rows = malloc(length * bytes);
    if (!rows)
        luaL_error(L, "mesh: no memory for %s", f->name);
    return rows;
}

static void read_vertices(lua_State *L, const field *f, void *at)
{
    duet_mesh *mesh = at;
    float *to = make_rows(L, f, 3 * (uint64_t)DUET_MOST_TRIANGLES, &mesh->n_vertices, sizeof *to);
    mesh->vertices = to;
    for (uint32_t i = 0; i < 3 * mesh->n_vertices; ++i) {
        if (lua_rawgeti(L, -1, (lua_Integer)i + 1) != LUA_TNUMBER)
            field_raise(L, f->name, "mesh: vertices must be numbers");
        to[i] = (float)lua_tonumber(L, -1);
        lua_pop(L, 1);
    }
}

static void read_triangles(lua_State *L, const field *f, void *at)
{
    duet_mesh *mesh = at;
    uint32_t *to = make_rows(L, f, DUET_MOST_TRIANGLES, &mesh->n_triangles, sizeof *to);
    mesh->triangles = to;
    for (uint32_t i = 0; i < 3 * mesh->n_triangles; ++i) {
        lua_rawgeti(L, -1, (lua_Integer)i + 1);
        lua_Integer vertex = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : -1;
        if (vertex < 0 || vertex >= UINT32_MAX)
            field_raise(L, f->name, "mesh: triangles must be whole numbers from 0 on");
        to[i] = (uint32_t)vertex;
        lua_pop(L, 1);
    }
}

// ---------------------------------------------------------------- both

enum { HAS_FILE = 1, HAS_SCALE = 2, HAS_VERTICES = 4, HAS_TRIANGLES = 8 };

static const field mesh_fields[] = {
    {.name = "file", .type = &field_unread},
    {.name = "scale", .type = &field_unread},
    {.name = "vertices",
     .type = &(const field_type){.read = read_vertices},
     .expected = "a list of numbers, three a vertex"},
    {.name = "triangles",
     .type = &(const field_type){.read = read_triangles},
     .expected = "a list of numbers of vertices, three a triangle"},
    GROUND_FIELDS(duet_mesh),
    FIELD(field_carrier, duet_mesh, carrier),
    {0},
};

// From the table on top of the stack, which has a file.
static void read_file(lua_State *L, duet_mesh *mesh, const char *beside)
{
    duet_error why = {0};
    const char *name = "";
    double scale = 1.0;
    field_read_one(L, -1, &scale_field, &scale);
    field_read_one(L, -1, &file_field, &name);
    if (beside && !is_below(name))
        field_raise(L, "file", "mesh: file is '%s'; expected " A_FILE, name);
    if (!load(mesh, name, scale, beside, &why))
        field_raise(L, "mesh", "mesh: %s", why.text);
}

void mesh_read(lua_State *L, duet_mesh *mesh, const char *beside)
{
    *mesh = (duet_mesh){0};
    uint64_t given = field_read_row(L, -1, table, mesh_fields, mesh);
    uint64_t lists = given & (HAS_VERTICES | HAS_TRIANGLES), file = given & (HAS_FILE | HAS_SCALE);
    if (lists ? file || lists != (HAS_VERTICES | HAS_TRIANGLES) : !(file & HAS_FILE))
        field_raise(L, "mesh", "a mesh has a file and its scale, or vertices and triangles");
    if (file)
        read_file(L, mesh, beside);
}
