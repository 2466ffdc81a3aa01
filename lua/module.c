// SPDX-License-Identifier: MIT
// The module's table: one line a noun.
#include "duet_lua.h"

#include "lua/nouns.h"

int luaopen_duet(lua_State *L)
{
    if (!L)
        return 0;
    luaL_checkversion(L);
    lua_newtable(L);
    lua_pushstring(L, duet_version());
    lua_setfield(L, -2, "version");
    array_open(L);
    device_open_lua(L);
    plan_open_lua(L);
    device_pair_open_lua(L);
    scene_open_lua(L);
    world_open_lua(L);
    result_open_lua(L);
    search_open_lua(L);
    tune_open_lua(L);
    online_open_lua(L);
    motion_open_lua(L);
    source_open_lua(L);
    level_open_lua(L);
    profiles_open_lua(L);
    pair_query_open_lua(L);
    carried_open_lua(L);
    return 1;
}
