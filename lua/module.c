// SPDX-License-Identifier: MIT
// The module's table, to which each noun adds; and the parts that are written in Lua: require
// "duet.frame", "duet.plot", "duet.timeline" and "duet.lab" find them inside the library.
#include "duet_lua.h"

#include "base/blob.h"
#include "lua/nouns.h"

void load_carried(lua_State *L, const char *path)
{
    const blob *b = blob_find(path);
    const char *name = lua_pushfstring(L, "@%s", path);
    const int status = luaL_loadbufferx(L, b->bytes, b->length, name, "t");
    lua_remove(L, -2);
    if (status != LUA_OK)
        lua_error(L);
}

// Leaves what the text returns on the stack.
static int run_carried(lua_State *L, const char *path)
{
    if (!L)
        return 0;
    load_carried(L, path);
    lua_call(L, 0, 1);
    return 1;
}

#define CARRIED(X) X(frame) X(lab) X(plot) X(timeline)

#define OPEN_CARRIED(part)                          \
    int luaopen_duet_##part(lua_State *L)           \
    {                                               \
        return run_carried(L, "lua/" #part ".lua"); \
    }
CARRIED(OPEN_CARRIED)

static void preload_carried(lua_State *L)
{
#define MODULE(part) {"duet." #part, luaopen_duet_##part},
    static const luaL_Reg modules[] = {CARRIED(MODULE){NULL, NULL}};
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_PRELOAD_TABLE);
    luaL_setfuncs(L, modules, 0);
    lua_pop(L, 1);
}

int luaopen_duet(lua_State *L)
{
    if (!L)
        return 0;
    luaL_checkversion(L);
    lua_newtable(L);
    lua_pushstring(L, duet_version());
    lua_setfield(L, -2, "version");
    array_open(L);
#define OPEN_NOUN(noun) class_open_noun(L, &noun##_noun);
    LUA_NOUNS(OPEN_NOUN)
    lua_pushinteger(L, (lua_Integer)DUET_NO_BODY);
    lua_setfield(L, -2, "NO_BODY");
    lua_pushinteger(L, DUET_NO_OBJECT);
    lua_setfield(L, -2, "NO_OBJECT");
    preload_carried(L);
    return 1;
}
