// SPDX-License-Identifier: MIT
// Commands to a motion between its steps, and its states in place.
#include "lua/motion_commands.h"
#include "lua/nouns.h"
#include "runtime/commands/commands.h"

#include <string.h>

// ---------------------------------------------------------------- lists

// Pushes the field of a table, or nil; metatables are not asked. Returns whether there is one.
static bool push_raw(lua_State *L, int index, const char *name)
{
    lua_pushnil(L);
    if (lua_istable(L, index)) {
        lua_pushstring(L, name);
        lua_rawget(L, index);
        lua_replace(L, -2);
    }
    return !lua_isnil(L, -1);
}

duet_body_list command_check_list_lua(lua_State *L)
{
    const int index = 2;
    if (push_raw(L, index, "first")) {
        push_raw(L, index, "n");
        lua_Integer first = luaL_checkinteger(L, -2), n = luaL_checkinteger(L, -1);
        luaL_argcheck(L, first >= 0 && first <= UINT32_MAX && n >= 0 && n <= UINT32_MAX, index,
                      "first and n from 0");
        lua_pop(L, 2);
        return (duet_body_list){.first = (uint32_t)first, .n = (uint32_t)n};
    }
    lua_pop(L, 1);
    if (lua_type(L, index) == LUA_TNUMBER) {
        lua_Integer id = luaL_checkinteger(L, index);
        lua_createtable(L, 1, 0);
        lua_pushinteger(L, id);
        lua_rawseti(L, -2, 1);
        lua_replace(L, index);
    }
    const array *ids = array_check(L, index, ARRAY_IDS);
    luaL_argcheck(L, ids->n <= UINT32_MAX, index, "more than 2^32 - 1 ids");
    return (duet_body_list){.ids = ids->rows, .n = (uint32_t)ids->n};
}

// Takes as many rows as the list has bodies.
static const void *check_rows(lua_State *L, int index, array_kind kind, uint32_t n)
{
    const array *rows = array_check(L, index, kind);
    luaL_argcheck(L, rows->n == n, index, "as many rows as bodies");
    return rows->rows;
}

static uint32_t field_of(lua_State *L, int index)
{
    const char *name = field_text(L, index);
    for (uint32_t i = 0; name && duet_body_field_name(1u << i); ++i)
        if (strcmp(duet_body_field_name(1u << i), name) == 0)
            return 1u << i;
    return (uint32_t)luaL_error(
        L,
        "'%s' is no field that can be set; expected velocity, "
        "angular_velocity, mass, restitution, friction, filter, "
        "fixed_rotation, radius, rolling_resistance, surface_velocity or material",
        field_push_shown(L, index));
}

// "velocity" or { "velocity", "mass" }
static uint32_t check_fields(lua_State *L, int index)
{
    uint32_t fields = 0;
    if (!lua_istable(L, index))
        return field_of(L, index);
    for (lua_Unsigned k = 1; k <= lua_rawlen(L, index); ++k) {
        lua_rawgeti(L, index, (lua_Integer)k);
        fields |= field_of(L, lua_gettop(L));
        lua_pop(L, 1);
    }
    return fields;
}

// ---------------------------------------------------------------- commands

// The rows of each command.
#define ARRAY_OF_uint64_t ARRAY_IDS
#define ARRAY_OF_duet_pose ARRAY_POSES
#define ARRAY_OF_duet_body ARRAY_BODIES
#define ARRAY_OF_duet_force ARRAY_FORCES
#define ARRAY_OF_duet_impulse ARRAY_IMPULSES
#define ARRAY_OF_duet_transform ARRAY_TRANSFORMS
#define KIND_LIST(type) ARRAY_KINDS // no rows
#define KIND_DEF(type) ARRAY_KINDS
#define KIND_ROWS(type) ARRAY_OF_##type
#define KIND_FIELDS(type) ARRAY_OF_##type
#define KIND_ADD(type) ARRAY_OF_##type
static const array_kind row_kinds[] = {
#define COMMAND(number, name, form, bodies, effect, type, rows) [number] = KIND_##form(type),
#include "runtime/commands/commands.inl"
};

static const field def_fields[] = {
#define DEF_MEMBER(name) FIELD(field_double, duet_motion_def, name),
#include "runtime/commands/def_members.inl"
    {0},
};

// (list), (list, poses), (list, fields, bodies)
static void read_listed(lua_State *L, command *c)
{
    int at = 3;
    c->list = command_check_list_lua(L);
    if (c->op->form == COMMAND_FIELDS)
        c->fields = check_fields(L, at++);
    if (c->op->rows)
        c->rows = check_rows(L, at, row_kinds[c->op->number], c->list.n);
}

// (poses, bodies); leaves the array of their ids on the stack.
static void read_coming(lua_State *L, command *c)
{
    lua_settop(L, 3);
    const array *poses = array_check(L, 2, ARRAY_POSES);
    luaL_argcheck(L, poses->n <= UINT32_MAX, 2, "more than 2^32 - 1 objects");
    c->list.n = (uint32_t)poses->n;
    c->rows = poses->rows;
    c->new_bodies = lua_isnil(L, 3) ? NULL : check_rows(L, 3, ARRAY_BODIES, c->list.n);
    c->new_ids = array_push(L, ARRAY_IDS, c->list.n)->rows;
}

// The method's upvalue is the command's number in commands.inl.
command command_read_lua(lua_State *L, duet_motion_def *def)
{
    command c = {.op = command_op_at((uint32_t)lua_tointeger(L, lua_upvalueindex(1)))};
    if (c.op->form == COMMAND_ADD) {
        read_coming(L, &c);
    } else if (c.op->form == COMMAND_DEF) {
        field_read(L, 2, "what of a motion can change", def_fields, def);
        c.list.n = 1;
        c.rows = def;
    } else {
        read_listed(L, &c);
    }
    return c;
}

int command_push_lua(lua_State *L, const command *c, bool ok, const duet_error *err)
{
    return ok && c->op->form == COMMAND_ADD ? 1 : class_push_done(L, ok, err);
}

static int give(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_motion_def def = *duet_motion_get_def(motion);
    command c = command_read_lua(L, &def);
    return command_push_lua(L, &c, command_give(motion, &c, &err), &err);
}

// ---------------------------------------------------------------- what is asked

static int motion_def(lua_State *L)
{
    field_push_table(L, def_fields, duet_motion_get_def(motion_check_lua(L)));
    return 1;
}

// motion:ids() or, of some places, motion:ids(first, n)
static int motion_ids(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    lua_Integer count = duet_motion_get_count(motion);
    lua_Integer first = luaL_optinteger(L, 2, 0);
    luaL_argcheck(L, first >= 0 && first <= count, 2, "a place from 0");
    lua_Integer n = luaL_optinteger(L, 3, count - first);
    luaL_argcheck(L, n >= 0 && n <= count - first, 3, "as many places as there are");
    array *ids = array_push(L, ARRAY_IDS, (uint64_t)n);
    return duet_motion_get_ids(motion, (uint32_t)first, (uint32_t)n, ids->rows, &err)
               ? 1
               : class_push_failure(L, &err);
}

static int motion_has_body(lua_State *L)
{
    lua_pushboolean(L,
                    duet_motion_has_body(motion_check_lua(L), (uint64_t)luaL_checkinteger(L, 2)));
    return 1;
}

static int motion_user_data(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = command_check_list_lua(L);
    array *data = array_push(L, ARRAY_IDS, list.n);
    return duet_motion_get_user_data(motion, list, data->rows, &err) ? 1
                                                                     : class_push_failure(L, &err);
}

// ---------------------------------------------------------------- states in place

static duet_state_part check_part(lua_State *L, int index)
{
    static const char *const names[] = {"centres", "rotations", "velocities", "angular_velocities",
                                        NULL};
    return (duet_state_part)luaL_checkoption(L, index, NULL, names);
}

// motion:map_states(part, access, first, n) -> rows that hold until unmap_states
static int motion_map_states(lua_State *L)
{
    static const char *const accesses[] = {"read", "write", NULL};
    duet_error err = {0};
    uint64_t *maps = motion_maps_lua(L);
    duet_motion *motion = motion_check_lua(L);
    duet_state_part part = check_part(L, 2);
    duet_map_access access = (duet_map_access)luaL_checkoption(L, 3, NULL, accesses);
    lua_Integer first = luaL_optinteger(L, 4, 0);
    lua_Integer n = luaL_optinteger(L, 5, (lua_Integer)duet_motion_get_count(motion) - first);
    luaL_argcheck(L, first >= 0 && first <= UINT32_MAX, 4, "a place from 0");
    luaL_argcheck(L, n >= 0 && n <= UINT32_MAX, 5, "a number of places from 0");
    void *rows = duet_motion_map_states(motion, part, access, (uint32_t)first, (uint32_t)n, &err);
    if (!rows)
        return class_push_failure(L, &err);
    array_push_view(
        L, duet_motion_get_def(motion)->doubles ? ARRAY_DOUBLE_STATE_ROWS : ARRAY_STATE_ROWS,
        access == DUET_MAP_READ ? ARRAY_FIXED : ARRAY_OPEN, rows, (uint64_t)n, &maps[part]);
    return 1;
}

static int motion_unmap_states(lua_State *L)
{
    duet_error err = {0};
    uint64_t *maps = motion_maps_lua(L);
    duet_state_part part = check_part(L, 2);
    bool ok = duet_motion_unmap_states(motion_check_lua(L), part, &err);
    maps[part] += ok;
    return class_push_done(L, ok, &err);
}

const lua_noun motion_commands_noun = {
    {NULL},
    (const lua_method[]){METHODS(motion, ids, has_body, user_data, def, map_states, unmap_states),

#define COMMAND(number, name, form, bodies, effect, type, rows) \
    {"duet.motion:" #name, give, number},
#include "runtime/commands/commands.inl"

                         {0}}};
