// SPDX-License-Identifier: MIT
// States of a motion in place; with the motion's other methods.
#include "lua/nouns.h"

static duet_state_part check_part(lua_State *L, int index)
{
    static const char *const names[] = {"centres", "rotations", "velocities", "angular_velocities",
                                        NULL};
    return (duet_state_part)luaL_checkoption(L, index, NULL, names);
}

// motion:map_states(part, access, first, n) -> rows that hold until unmap_states
int motion_map_states_lua(lua_State *L)
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

int motion_unmap_states_lua(lua_State *L)
{
    duet_error err = {0};
    uint64_t *maps = motion_maps_lua(L);
    duet_state_part part = check_part(L, 2);
    bool ok = duet_motion_unmap_states(motion_check_lua(L), part, &err);
    maps[part] += ok;
    return class_push_done(L, ok, &err);
}
