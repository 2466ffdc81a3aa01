// SPDX-License-Identifier: MIT
// A motion's def as a table, and effects by their names.
#include "lua/motion.h"
#include "runtime/scene/mesh_file.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_heights.h"
#include "runtime/scene/scene_materials.h"
#include "runtime/scene/scene_mesh.h"

#include <lauxlib.h>

// The effects' names, one bit after the other; NULL past the last.
static const char *effect_at(uint32_t i)
{
    return i < 32 ? duet_effect_name(1u << i) : NULL;
}

void motion_push_effects(lua_State *L, uint32_t effects)
{
    lua_newtable(L);
    for (uint32_t i = 0; effect_at(i); ++i) {
        if (!(effects & 1u << i))
            continue;
        lua_pushstring(L, effect_at(i));
        lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    }
}

static int list_effects(lua_State *L)
{
    motion_push_effects(L, DUET_EFFECT_ALL);
    return 1;
}

// { "events", "sleep" } -> bits
static void read_effects(lua_State *L, const member *m, void *at)
{
    uint32_t *effects = at;
    if (!lua_istable(L, -1))
        member_refuse(L, m, "a list of effects' names");
    for (lua_Unsigned n = lua_rawlen(L, -1), k = 1; k <= n; ++k) {
        lua_rawgeti(L, -1, (lua_Integer)k);
        const char *name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "?";
        uint32_t effect = scene_effect_named(name);
        if (!effect)
            luaL_error(L, "field '%s': there is no effect '%s'; duet.effects() lists them", m->name,
                       name);
        *effects |= effect;
        lua_pop(L, 1);
    }
}

static void push_wants(lua_State *L, const member *m, const void *at)
{
    (void)m;
    motion_push_effects(L, *(const uint32_t *)at);
}

static const member_type member_effects = {.read = read_effects, .push = push_wants};

static const char *boundary_name(int boundary)
{
    static const char *const names[] = {"none", "walls", "periodic"};
    return boundary < 3 ? names[boundary] : NULL;
}

const duet_heights *motion_push_heights(lua_State *L)
{
    duet_heights read;
    const char *fault = heights_read(L, &read);
    if (fault)
        luaL_error(L, "field 'heights': %s", fault);
    size_t bytes = (size_t)read.nx * read.ny * sizeof *read.heights;
    duet_heights *kept = lua_newuserdatauv(L, sizeof *kept + bytes, 0);
    float *values = (float *)(kept + 1);
    lua_pushvalue(L, -2);
    fault = heights_read_values(L, &read, values);
    lua_pop(L, 1);
    if (fault)
        luaL_error(L, "field 'heights': %s", fault);
    *kept = read;
    kept->heights = values;
    return kept;
}

// heights = { nx = 65, ... }: kept in the registry until a motion has copied them.
static void read_heights(lua_State *L, const member *m, void *at)
{
    if (!lua_istable(L, -1))
        member_refuse(L, m, "a table of nx, ny, spacing, origin, values and material");
    *(const duet_heights **)at = motion_push_heights(L);
    lua_setfield(L, LUA_REGISTRYINDEX, "duet heights");
}

static const member_type member_heights = {.read = read_heights};

static int free_mesh(lua_State *L)
{
    mesh_file_free(lua_touserdata(L, 1));
    return 0;
}

const duet_mesh *motion_push_mesh(lua_State *L)
{
    duet_error why = {0};
    duet_mesh *mesh = lua_newuserdatauv(L, sizeof *mesh, 0);
    *mesh = (duet_mesh){0};
    lua_createtable(L, 0, 1);
    lua_pushcfunction(L, free_mesh);
    lua_setfield(L, -2, "__gc");
    lua_setmetatable(L, -2);
    lua_pushvalue(L, -2);
    if (!mesh_read(L, mesh, NULL, &why))
        luaL_error(L, "field 'mesh': %s", why.text);
    lua_pop(L, 1);
    return mesh;
}

// mesh = { file = "drum.stl" }: kept likewise.
static void read_mesh(lua_State *L, const member *m, void *at)
{
    if (!lua_istable(L, -1))
        member_refuse(L, m, "a table of file and scale, or vertices and triangles");
    *(const duet_mesh **)at = motion_push_mesh(L);
    lua_setfield(L, LUA_REGISTRYINDEX, "duet mesh");
}

static const member_type member_mesh = {.read = read_mesh};

// script = function(step, motion): kept beside the pair.
static void read_script(lua_State *L, const member *m, void *at)
{
    (void)at;
    if (!lua_isfunction(L, -1))
        member_refuse(L, m, "a function of the step and the motion");
}

static const member_type member_script = {.read = read_script};

static void check_row(lua_State *L, const member *m, const char *fault, lua_Integer row)
{
    if (fault)
        luaL_error(L, "field '%s', row %I: expected %s", m->name, row, fault);
}

static void read_materials(lua_State *L, const member *m, void *at)
{
    lua_Integer row = 0;
    const char *fault = scene_take_materials(L, at, &row);
    check_row(L, m, fault, row);
}

static void read_material_pairs(lua_State *L, const member *m, void *at)
{
    lua_Integer row = 0;
    const char *fault = scene_take_material_pairs(L, at, &row);
    check_row(L, m, fault, row);
}

static const member_type member_materials = {.read = read_materials};
static const member_type member_material_pairs = {.read = read_material_pairs};

const member motion_def_members[] = {
    {"script", &member_script, 0, 1, NULL},
    MEMBERS(duet_motion_def, plan, dims),
    MEMBER(member_effects, duet_motion_def, wants),
    MEMBERS(duet_motion_def, doubles, origin, origin_edge, gravity, attraction, centre, drag),
    MEMBER_ENUM(duet_motion_def, boundary, boundary_name),
    MEMBERS(duet_motion_def, lower, upper, dt, substeps),
    MEMBER_ENUM(duet_motion_def, integrator, scene_integrator_name),
    MEMBERS(duet_motion_def, skin, slop, max_push_speed, restitution_threshold, sleep_speed,
            sleep_after, hit_speed, event_mask),
    {"materials", &member_materials, 0, sizeof(duet_motion_def), NULL},
    {"material_pairs", &member_material_pairs, 0, sizeof(duet_motion_def), NULL},
    MEMBER(member_heights, duet_motion_def, heights),
    MEMBER(member_mesh, duet_motion_def, mesh),
    MEMBERS(duet_motion_def, stage_times),
    {0},
};

// duet.game_motion_def(dims) -> a def that a script may change
static int game_motion_def(lua_State *L)
{
    static const member said[] = {
        MEMBERS(duet_motion_def, dims),
        MEMBER(member_effects, duet_motion_def, wants),
        MEMBERS(duet_motion_def, gravity, slop),
        {0},
    };
    lua_Integer dims = luaL_optinteger(L, 1, 3);
    luaL_argcheck(L, dims == 2 || dims == 3, 1, "2 or 3 dims");
    duet_motion_def def = duet_game_motion_def(NULL, (uint32_t)dims);
    member_push_table(L, said, &def);
    return 1;
}

const lua_noun motion_def_noun = {{NULL},
                                  (const lua_method[]){{"duet.effects", list_effects, 0},
                                                       {"duet.game_motion_def", game_motion_def, 0},
                                                       {0}}};
