// SPDX-License-Identifier: MIT
// A motion's def as a table.
#include "lua/motion.h"
#include "runtime/scene/mesh_file.h"
#include "runtime/scene/scene_fields.h"
#include "runtime/scene/scene_heights.h"
#include "runtime/scene/scene_mesh.h"

#include <lauxlib.h>

static int list_effects(lua_State *L)
{
    scene_push_effects(L, DUET_EFFECT_ALL);
    return 1;
}

const duet_heights *motion_push_heights(lua_State *L)
{
    duet_heights read;
    heights_read(L, &read);
    size_t bytes = (size_t)read.nx * read.ny * sizeof *read.heights;
    duet_heights *kept = lua_newuserdatauv(L, sizeof *kept + bytes, 0);
    float *values = (float *)(kept + 1);
    lua_pushvalue(L, -2);
    heights_read_values(L, &read, values);
    lua_pop(L, 1);
    *kept = read;
    kept->heights = values;
    return kept;
}

// heights = { nx = 65, ... }: kept in the registry until a motion has copied them.
static void read_heights(lua_State *L, const field *f, void *at)
{
    (void)f;
    *(const duet_heights **)at = motion_push_heights(L);
    lua_setfield(L, LUA_REGISTRYINDEX, "duet heights");
}

static const field_type field_heights = {.read = read_heights};

static int free_mesh(lua_State *L)
{
    mesh_file_free(lua_touserdata(L, 1));
    return 0;
}

const duet_mesh *motion_push_mesh(lua_State *L)
{
    duet_mesh *mesh = lua_newuserdatauv(L, sizeof *mesh, 0);
    *mesh = (duet_mesh){0};
    lua_createtable(L, 0, 1);
    lua_pushcfunction(L, free_mesh);
    lua_setfield(L, -2, "__gc");
    lua_setmetatable(L, -2);
    lua_pushvalue(L, -2);
    mesh_read(L, mesh, NULL);
    lua_pop(L, 1);
    return mesh;
}

// mesh = { file = "drum.stl" }: kept likewise.
static void read_mesh(lua_State *L, const field *f, void *at)
{
    (void)f;
    *(const duet_mesh **)at = motion_push_mesh(L);
    lua_setfield(L, LUA_REGISTRYINDEX, "duet mesh");
}

static const field_type field_mesh = {.read = read_mesh};

// script = function(step, motion): kept beside the pair.
static void read_script(lua_State *L, const field *f, void *at)
{
    (void)at;
    if (!lua_isfunction(L, -1))
        field_refuse(L, f, "a function of the step and the motion");
}

static const field_type field_script = {.read = read_script};

const field motion_def_fields[] = {
    {.name = "script", .type = &field_script},
    FIELD(field_plan, duet_motion_def, plan),
    FIELDS(duet_motion_def, dims),
    FIELD(field_effects, duet_motion_def, wants),
    FIELDS(duet_motion_def, doubles, origin, origin_edge, gravity, attraction, centre, drag),
    FIELD_ENUM(duet_motion_def, boundary, scene_boundary_name),
    FIELDS(duet_motion_def, lower, upper, dt, substeps),
    FIELD_ENUM(duet_motion_def, integrator, scene_integrator_name),
    FIELDS(duet_motion_def, skin, slop, max_push_speed, restitution_threshold, sleep_speed,
           sleep_after, hit_speed, event_mask),
    {.name = "materials", .type = &field_materials},
    {.name = "material_pairs", .type = &field_material_pairs},
    FIELD(field_heights, duet_motion_def, heights),
    FIELD(field_mesh, duet_motion_def, mesh),
    FIELDS(duet_motion_def, stage_times),
    {0},
};

// duet.game_motion_def(dims) -> a def that a script may change
static int game_motion_def(lua_State *L)
{
    static const field said[] = {
        FIELDS(duet_motion_def, dims),
        FIELD(field_effects, duet_motion_def, wants),
        FIELDS(duet_motion_def, gravity, slop),
        {0},
    };
    lua_Integer dims = luaL_optinteger(L, 1, 3);
    luaL_argcheck(L, dims == 2 || dims == 3, 1, "2 or 3 dims");
    duet_motion_def def = duet_game_motion_def(NULL, (uint32_t)dims);
    field_push_table(L, said, &def);
    return 1;
}

const lua_noun motion_def_noun = {{NULL},
                                  (const lua_method[]){{"duet.effects", list_effects, 0},
                                                       {"duet.game_motion_def", game_motion_def, 0},
                                                       {0}}};
