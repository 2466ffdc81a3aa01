// SPDX-License-Identifier: MIT
#include "gen/parameters.h"
#include "gen/script.h"

#include <lauxlib.h>
#include <string.h>

// Pushes the least name of the table at index that comes after `after` (NULL:
// the least of all); false where there is none.
static bool push_name_after(lua_State *L, int index, const char *after)
{
    const char *least = NULL;
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        script_spend(L, 1);
        const char *name = lua_tostring(L, -2);
        if ((!after || strcmp(name, after) > 0) && (!least || strcmp(name, least) < 0))
            least = name;
    }
    if (least)
        lua_pushstring(L, least);
    return least != NULL;
}

// "a, b, c", in alphabetical order, since Lua's own changes from run to run.
static const char *push_names(lua_State *L, int index)
{
    lua_pushstring(L, "");
    const char *last = NULL;
    while (push_name_after(L, index, last)) {
        last = lua_tostring(L, -1);
        lua_pushfstring(L, "%s%s%s", lua_tostring(L, -2), *lua_tostring(L, -2) ? ", " : "", last);
        lua_replace(L, -3);
        lua_pop(L, 1); // the table keeps the name alive
    }
    return lua_tostring(L, -1);
}

static bool has_nul(lua_State *L, int index)
{
    size_t length;
    const char *chars = lua_tolstring(L, index, &length);
    return strlen(chars) != length;
}

static void check_defaults(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            luaL_error(L, "a parameter has a name: parameters{ name = default }");
        if (has_nul(L, -2) || (lua_type(L, -1) == LUA_TSTRING && has_nul(L, -1)))
            luaL_error(L, "parameter '%s': expected a name and a default without NUL",
                       lua_tostring(L, -2));
        int type = lua_type(L, -1);
        if (type != LUA_TNUMBER && type != LUA_TBOOLEAN && type != LUA_TSTRING)
            luaL_error(L, "parameter '%s': its default must be a number, boolean or string",
                       lua_tostring(L, -2));
    }
}

void parameters_declare(lua_State *L, bool *declared)
{
    if (*declared)
        luaL_error(L, "parameters are declared a second time");
    *declared = true;
    lua_settop(L, 1);
    check_defaults(L);
}

uint64_t parameters_seed(lua_State *L)
{
    lua_getfield(L, 1, "seed");
    uint64_t seed = (uint64_t)lua_tointeger(L, -1);
    lua_settop(L, 1);
    return seed;
}

// Pushes text as a value like the default on top of the stack; false where it
// is none.
static bool push_like_default(lua_State *L, const char *text)
{
    if (lua_isboolean(L, -1)) {
        lua_pushboolean(L, strcmp(text, "true") == 0);
        return strcmp(text, "true") == 0 || strcmp(text, "false") == 0;
    }
    if (lua_type(L, -1) == LUA_TSTRING) {
        lua_pushstring(L, text);
        return true;
    }
    bool whole = lua_isinteger(L, -1);
    if (lua_stringtonumber(L, text) == 0)
        return false;
    int is_integer = 0;
    lua_Integer integer = lua_tointegerx(L, -1, &is_integer); // 1e6 is one
    if (whole && is_integer)
        lua_pushinteger(L, integer);
    return !whole || is_integer;
}

static const char *kind_of_default(lua_State *L)
{
    if (lua_isboolean(L, -1))
        return "true or false";
    return lua_isinteger(L, -1) ? "an integer" : "a number";
}

void parameters_set(lua_State *L, const char *whose, const char *name, const char *value)
{
    duet_status before = script_set_failure(L, DUET_STATUS_BAD_ARGUMENT);
    if (lua_getfield(L, 1, name) == LUA_TNIL)
        luaL_error(L, "no parameter '%s'; %s has %s", name, whose, push_names(L, 1));
    const char *kind = kind_of_default(L);
    if (!push_like_default(L, value))
        luaL_error(L, "parameter %s is '%s'; it must be %s", name, value, kind);
    lua_setfield(L, 1, name);
    lua_settop(L, 1);
    script_set_failure(L, before);
}
