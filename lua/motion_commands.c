// SPDX-License-Identifier: MIT
// Commands to a motion between its steps, and its states in place.
#include "lua/nouns.h"

#include <string.h>

// ---------------------------------------------------------------- lists

// ids, or { first = place, n = count }, or one id.
static duet_body_list check_list(lua_State *L, int index)
{
    if (lua_type(L, index) == LUA_TTABLE && lua_getfield(L, index, "first") != LUA_TNIL) {
        lua_getfield(L, index, "n");
        lua_Integer first = luaL_checkinteger(L, -2), n = luaL_checkinteger(L, -1);
        luaL_argcheck(L, first >= 0 && first <= UINT32_MAX && n >= 0 && n <= UINT32_MAX, index,
                      "first and n from 0");
        lua_pop(L, 2);
        return (duet_body_list){.first = (uint32_t)first, .n = (uint32_t)n};
    }
    if (lua_type(L, index) == LUA_TTABLE)
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

// As many rows as the list has bodies.
static const void *check_rows(lua_State *L, int index, array_kind kind, uint32_t n)
{
    const array *rows = array_check(L, index, kind);
    luaL_argcheck(L, rows->n == n, index, "as many rows as bodies");
    return rows->rows;
}

// ---------------------------------------------------------------- bodies come and go

// motion:add_bodies(poses, bodies) -> their ids
static int add_bodies(lua_State *L)
{
    duet_error err = {0};
    lua_settop(L, 3);
    duet_motion *motion = motion_check_lua(L);
    const array *poses = array_check(L, 2, ARRAY_POSES);
    luaL_argcheck(L, poses->n <= UINT32_MAX, 2, "more than 2^32 - 1 objects");
    uint32_t n = (uint32_t)poses->n;
    const duet_body *bodies = lua_isnil(L, 3) ? NULL : check_rows(L, 3, ARRAY_BODIES, n);
    array *ids = array_push(L, ARRAY_IDS, n);
    return duet_motion_add_bodies(motion, poses->rows, bodies, n, ids->rows, &err)
               ? 1
               : class_push_failure(L, &err);
}

typedef bool list_call(duet_motion *motion, duet_body_list list, duet_error *err);

static list_call *const list_calls[] = {duet_motion_remove_bodies, duet_motion_disable_bodies,
                                        duet_motion_enable_bodies, duet_motion_wake_bodies,
                                        duet_motion_sleep_bodies};

// motion:remove_bodies(list) and others; the upvalue is the place in list_calls.
static int call_with_list(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    list_call *call = list_calls[lua_tointeger(L, lua_upvalueindex(1))];
    return class_push_done(L, call(motion, check_list(L, 2), &err), &err);
}

// motion:ids() or, of some places, motion:ids(first, n)
static int get_ids(lua_State *L)
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

static int has_body(lua_State *L)
{
    lua_pushboolean(L,
                    duet_motion_has_body(motion_check_lua(L), (uint64_t)luaL_checkinteger(L, 2)));
    return 1;
}

static int set_user_data(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    const uint64_t *data = check_rows(L, 3, ARRAY_IDS, list.n);
    return class_push_done(L, duet_motion_set_user_data(motion, list, data, &err), &err);
}

static int get_user_data(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    array *data = array_push(L, ARRAY_IDS, list.n);
    return duet_motion_get_user_data(motion, list, data->rows, &err) ? 1
                                                                     : class_push_failure(L, &err);
}

// ---------------------------------------------------------------- what is set

static uint32_t field_of(lua_State *L, int index)
{
    const char *name = lua_type(L, index) == LUA_TSTRING ? lua_tostring(L, index) : "?";
    for (uint32_t i = 0; duet_body_field_name(1u << i); ++i)
        if (strcmp(duet_body_field_name(1u << i), name) == 0)
            return 1u << i;
    return (uint32_t)luaL_error(L,
                                "'%s' is no field that can be set; expected velocity, "
                                "angular_velocity, mass, restitution, friction, filter or "
                                "fixed_rotation",
                                name);
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

// motion:set_bodies(ids, fields, bodies)
static int set_bodies(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    uint32_t fields = check_fields(L, 3);
    const duet_body *bodies = check_rows(L, 4, ARRAY_BODIES, list.n);
    return class_push_done(L, duet_motion_set_bodies(motion, list, fields, bodies, &err), &err);
}

static int set_poses(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    const duet_pose *poses = check_rows(L, 3, ARRAY_POSES, list.n);
    return class_push_done(L, duet_motion_set_poses(motion, list, poses, &err), &err);
}

static int set_targets(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    const duet_transform *targets = check_rows(L, 3, ARRAY_TRANSFORMS, list.n);
    return class_push_done(L, duet_motion_set_targets(motion, list, targets, &err), &err);
}

// What of a def can change.
static const member def_members[] = {
    MEMBER(member_double, duet_motion_def, gravity),
    MEMBER(member_double, duet_motion_def, attraction),
    MEMBER(member_double, duet_motion_def, centre),
    MEMBER(member_double, duet_motion_def, drag),
    MEMBER(member_double, duet_motion_def, lower),
    MEMBER(member_double, duet_motion_def, upper),
    MEMBER(member_double, duet_motion_def, max_push_speed),
    MEMBER(member_double, duet_motion_def, restitution_threshold),
    MEMBER(member_double, duet_motion_def, sleep_speed),
    MEMBER(member_double, duet_motion_def, sleep_after),
    {0},
};

static int set_def(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_motion_def def = *duet_motion_get_def(motion);
    member_read_table(L, 2, "what of a motion can change", def_members, &def);
    return class_push_done(L, duet_motion_set_def(motion, &def, &err), &err);
}

static int get_def(lua_State *L)
{
    member_push_table(L, def_members, duet_motion_get_def(motion_check_lua(L)));
    return 1;
}

// ---------------------------------------------------------------- what pushes

static int apply_forces(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    const duet_force *forces = check_rows(L, 3, ARRAY_FORCES, list.n);
    return class_push_done(L, duet_motion_apply_forces(motion, list, forces, &err), &err);
}

static int apply_impulses(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    duet_body_list list = check_list(L, 2);
    const duet_impulse *impulses = check_rows(L, 3, ARRAY_IMPULSES, list.n);
    return class_push_done(L, duet_motion_apply_impulses(motion, list, impulses, &err), &err);
}

// ---------------------------------------------------------------- states in place

static duet_state_part check_part(lua_State *L, int index)
{
    static const char *const names[] = {"centres", "rotations", "velocities", "angular_velocities",
                                        NULL};
    return (duet_state_part)luaL_checkoption(L, index, NULL, names);
}

// motion:map_states(part, access, first, n) -> rows that hold until unmap_states
static int map_states(lua_State *L)
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
    array *a = array_push_view(
        L, duet_motion_get_def(motion)->doubles ? ARRAY_DOUBLE_STATE_ROWS : ARRAY_STATE_ROWS, rows,
        (uint64_t)n, 1, &maps[part]);
    a->fixed = access == DUET_MAP_READ;
    return 1;
}

static int unmap_states(lua_State *L)
{
    duet_error err = {0};
    uint64_t *maps = motion_maps_lua(L);
    duet_state_part part = check_part(L, 2);
    bool ok = duet_motion_unmap_states(motion_check_lua(L), part, &err);
    maps[part] += ok;
    return class_push_done(L, ok, &err);
}

static const luaL_Reg methods[] = {{"add_bodies", add_bodies},
                                   {"ids", get_ids},
                                   {"has_body", has_body},
                                   {"set_user_data", set_user_data},
                                   {"user_data", get_user_data},
                                   {"set_bodies", set_bodies},
                                   {"set_poses", set_poses},
                                   {"set_targets", set_targets},
                                   {"set_def", set_def},
                                   {"def", get_def},
                                   {"apply_forces", apply_forces},
                                   {"apply_impulses", apply_impulses},
                                   {"map_states", map_states},
                                   {"unmap_states", unmap_states},
                                   {NULL, NULL}};

static const lua_shared shared[] = {
    {"remove_bodies", call_with_list, 0}, {"disable_bodies", call_with_list, 1},
    {"enable_bodies", call_with_list, 2}, {"wake_bodies", call_with_list, 3},
    {"sleep_bodies", call_with_list, 4},  {NULL, NULL, 0}};

void motion_commands_open_lua(lua_State *L)
{
    class_add_methods(L, "duet.motion", methods, shared);
}
