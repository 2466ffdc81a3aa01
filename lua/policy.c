// SPDX-License-Identifier: MIT
#include "lua/policy.h"

#include "base/beneath.h"

#include <lauxlib.h>

// In the registry: nil where all is allowed, else the set of named paths.
static const char key = 0;

void policy_restrict(lua_State *L, const char *const *paths, int n_paths)
{
    lua_newtable(L);
    for (int i = 0; i < n_paths; ++i) {
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, paths[i]);
    }
    lua_rawsetp(L, LUA_REGISTRYINDEX, &key);
}

void policy_check_read(lua_State *L, const char *path)
{
    int allowed = 1;
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &key) != LUA_TNIL) {
        lua_getfield(L, -1, path);
        allowed = lua_toboolean(L, -1) || path_is_beneath(path);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    if (!allowed)
        luaL_error(L,
                   "'%s' is not below the current folder, or a link: name it on the command "
                   "line, or give --trust",
                   path);
}

void policy_check_trusted(lua_State *L, const char *what)
{
    int restricted = lua_rawgetp(L, LUA_REGISTRYINDEX, &key) != LUA_TNIL;
    lua_pop(L, 1);
    if (restricted)
        luaL_error(L, "%s needs 'duet lua --trust'", what);
}
