// SPDX-License-Identifier: MIT
// What a script finds: base without anything that loads, prints, catches errors
// or changes metatables; string without dump; table, math, utf8.
//
// Limits are looked at between instructions, and a library function is one
// instruction however long it works. Those that a script can make work for
// ever are guarded here. There is no pcall to swallow the error of a limit, no
// coroutine to leave the hook behind, and no metatable: a finalizer or an error
// handler would run with the hook switched off.
#include "gen/sandbox.h"
#include "gen/script.h"
#include "runtime/base/blob.h"

#include <lauxlib.h>
#include <lualib.h>
#include <string.h>

// Steps that a pattern may take in the worst case: some seconds.
#define MAX_PATTERN_STEPS 2e9

static const char *const base_names[] = {
    "error", "ipairs", "next", "select", "tonumber", "tostring", "type", "_VERSION",
};

// Calls what the guard stands before, in the guard's own frame, so that
// messages name the script's line.
static int pass_on(lua_State *L)
{
    return lua_tocfunction(L, lua_upvalueindex(1))(L);
}

static int guard_rep(lua_State *L)
{
    size_t length = 0, separator = 0;
    luaL_checklstring(L, 1, &length);
    luaL_optlstring(L, 3, "", &separator);
    if (length + separator > 0)
        return pass_on(L);
    lua_pushliteral(L, ""); // nothing, however often
    return 1;
}

static int guard_move(lua_State *L)
{
    lua_Integer from = luaL_checkinteger(L, 2);
    lua_Integer to = luaL_checkinteger(L, 3);
    if (to >= from)
        script_spend(L, (lua_Unsigned)to - (lua_Unsigned)from);
    return pass_on(L);
}

// Where a set such as [^]a-z%]] ends.
static const char *skip_set(const char *at, const char *end)
{
    at += at + 1 < end && at[1] == '^' ? 2 : 1;
    for (const char *first = at; at < end && (*at != ']' || at == first); ++at)
        if (*at == '%')
            ++at;
    return at;
}

// A repeat can take any length, so k of them on n bytes can be laid out in
// (n + k over k) ways; where the match begins is one more choice.
static double worst_steps(const char *pattern, size_t pattern_length, size_t n)
{
    double steps = 1;
    int choices = *pattern != '^';
    const char *end = pattern + pattern_length;
    for (const char *at = pattern; at < end; ++at) {
        choices += *at == '*' || *at == '+' || *at == '-' || (*at == '%' && at[1] == 'b');
        if (*at == '?')
            steps *= 2;
        if (*at == '[')
            at = skip_set(at, end);
        else if (*at == '%')
            ++at;
    }
    for (int k = 1; k <= choices; ++k)
        steps *= ((double)n + k) / k;
    return steps;
}

static int guard_pattern(lua_State *L)
{
    size_t n = 0, length = 0;
    luaL_checklstring(L, 1, &n);
    const char *pattern = luaL_checklstring(L, 2, &length);
    bool plain = lua_toboolean(L, lua_upvalueindex(2)) && lua_toboolean(L, 4);
    if (!plain && worst_steps(pattern, length, n) > MAX_PATTERN_STEPS)
        return luaL_error(L,
                          "the pattern could take too long on a text of %d bytes: match it "
                          "line by line, or with fewer repeats",
                          (int)n);
    script_spend(L, 1);
    return pass_on(L);
}

// Without a number the seed would be another one on each run.
static int guard_randomseed(lua_State *L)
{
    lua_Integer seed = luaL_checkinteger(L, 1);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_pushinteger(L, seed);
    lua_call(L, 1, 0);
    return 0;
}

// The usual assert, but its message has a place.
static int place_assert(lua_State *L)
{
    luaL_checkany(L, 1);
    if (lua_toboolean(L, 1))
        return lua_gettop(L);
    const char *message = luaL_optstring(L, 2, "assertion failed");
    return luaL_error(L, "%s", message);
}

// library[name] = guard, with the function that was there behind it.
static void put_guard(lua_State *L, const char *library, const char *name, lua_CFunction guard)
{
    lua_getglobal(L, library);
    lua_getfield(L, -1, name);
    lua_pushboolean(L, strcmp(name, "find") == 0);
    lua_pushcclosure(L, guard, 2);
    lua_setfield(L, -2, name);
    lua_pop(L, 1);
}

static void remove_field(lua_State *L, const char *library, const char *name)
{
    lua_getglobal(L, library);
    lua_pushnil(L);
    lua_setfield(L, -2, name);
    lua_pop(L, 1);
}

// Makes globals that hold the allowed base functions and no others.
static void open_base(lua_State *L)
{
    luaL_requiref(L, LUA_GNAME, luaopen_base, 0);
    lua_newtable(L);
    for (size_t i = 0; i < sizeof base_names / sizeof base_names[0]; ++i) {
        lua_getfield(L, -2, base_names[i]);
        lua_setfield(L, -2, base_names[i]);
    }
    lua_rawseti(L, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
    lua_pop(L, 1);
}

static void open_libraries(lua_State *L)
{
    luaL_requiref(L, LUA_STRLIBNAME, luaopen_string, 1);
    luaL_requiref(L, LUA_TABLIBNAME, luaopen_table, 1);
    luaL_requiref(L, LUA_MATHLIBNAME, luaopen_math, 1);
    luaL_requiref(L, LUA_UTF8LIBNAME, luaopen_utf8, 1);
    lua_pop(L, 4);
}

static void open_guards(lua_State *L)
{
    remove_field(L, "string", "dump");
    put_guard(L, "string", "rep", guard_rep);
    put_guard(L, "string", "find", guard_pattern);
    put_guard(L, "string", "match", guard_pattern);
    put_guard(L, "string", "gmatch", guard_pattern);
    put_guard(L, "string", "gsub", guard_pattern);
    put_guard(L, "table", "move", guard_move);
    put_guard(L, "math", "randomseed", guard_randomseed);
    lua_register(L, "assert", place_assert);
}

// The part of the sandbox that is written in Lua itself.
static void open_lua_part(lua_State *L)
{
    const blob *part = blob_find("gen/sandbox.lua");
    if (luaL_loadbufferx(L, part->bytes, part->length, "@gen/sandbox.lua", "t") != LUA_OK)
        lua_error(L);
    lua_call(L, 0, 0);
}

int sandbox_open(lua_State *L)
{
    open_base(L);
    open_libraries(L);
    open_guards(L);
    open_lua_part(L);
    return 0;
}
