// SPDX-License-Identifier: MIT
// What a script finds: base without anything that loads, prints, catches errors
// or changes metatables; string without dump; table, math, utf8.
//
// Limits are looked at between instructions and where memory is asked for
// (script.c). A library function is one instruction however long it works: one
// that works long on what is there already is guarded here, and takes from what
// the script has left. Patterns can need more steps than there is time, whatever
// their length, and are left out: find takes plain text. table.sort and pairs
// are Duet's own (sandbox.lua). There is no pcall to swallow the error of a
// limit, no coroutine to leave the hook behind, and no metatable: a finalizer
// or an error handler would run with the hook switched off.
#define _GNU_SOURCE // memmem, which is linear
#include "gen/sandbox.h"
#include "base/blob.h"

#include <lauxlib.h>
#include <lualib.h>
#include <stdbool.h>
#include <string.h>

// The cost of a function's work in instructions.
enum { BYTES_AN_INSTRUCTION = 32, VALUES_AN_INSTRUCTION = 4 };

// string.format writes up to 400 bytes for a number, slowly.
enum { MOST_FORMATTED = 250 };

static const char *const base_names[] = {
    "error", "ipairs", "next", "select", "tonumber", "tostring", "type", "_VERSION",
};

// Calls what the guard stands before, in the guard's own frame, so that
// messages name the script's line.
static int pass_on(lua_State *L)
{
    return lua_tocfunction(L, lua_upvalueindex(1))(L);
}

static void spend_values(lua_State *L, lua_Unsigned n)
{
    script_spend(L, n / VALUES_AN_INSTRUCTION);
}

// The numbers from..to, of which a table or text of n has no more than that.
static lua_Unsigned range(lua_Integer from, lua_Integer to, lua_Unsigned n)
{
    if (to < from)
        return 0;
    lua_Unsigned length = (lua_Unsigned)to - (lua_Unsigned)from;
    return length < n ? length : n;
}

// The work is counted by the values that go in or come out.
static int guard_values(lua_State *L)
{
    spend_values(L, (lua_Unsigned)lua_gettop(L));
    int n = pass_on(L);
    spend_values(L, (lua_Unsigned)n);
    return n;
}

// The text at 1 is read from its beginning to its end.
static int guard_text(lua_State *L)
{
    size_t n = lua_type(L, 1) == LUA_TSTRING ? lua_rawlen(L, 1) : 0;
    script_spend(L, n / BYTES_AN_INSTRUCTION);
    return guard_values(L);
}

// A part of the text at 1: (s, i, j), each counted from the end where negative.
static int guard_part(lua_State *L)
{
    lua_Integer n = lua_type(L, 1) == LUA_TSTRING ? (lua_Integer)lua_rawlen(L, 1) : 0;
    lua_Integer from = luaL_optinteger(L, 2, 1);
    lua_Integer to = luaL_optinteger(L, 3, -1);
    from = from < 0 ? n + from + 1 : from;
    to = to < 0 ? n + to + 1 : to;
    script_spend(L, range(from, to, (lua_Unsigned)n) / BYTES_AN_INSTRUCTION);
    return guard_values(L);
}

// (s, n, i): n characters on from a place.
static int guard_offset(lua_State *L)
{
    lua_Integer n = luaL_checkinteger(L, 2);
    size_t length = lua_type(L, 1) == LUA_TSTRING ? lua_rawlen(L, 1) : 0;
    script_spend(L, range(0, n < 0 ? -(n + 1) : n, length) / BYTES_AN_INSTRUCTION);
    return pass_on(L);
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

static lua_Unsigned length_of(lua_State *L)
{
    return lua_type(L, 1) == LUA_TTABLE ? lua_rawlen(L, 1) : 0;
}

// (t, at, value) and (t, at): what stands behind moves.
static int guard_shift(lua_State *L)
{
    lua_Unsigned n = length_of(L);
    if (lua_isinteger(L, 2) && (lua_gettop(L) == 3 || lua_toboolean(L, lua_upvalueindex(2))))
        spend_values(L, range(lua_tointeger(L, 2), (lua_Integer)n, n));
    return pass_on(L);
}

// (t, from, to), and with a text between them at 2 (t, separator, from, to).
static int guard_range(lua_State *L)
{
    lua_Unsigned n = length_of(L);
    int first = lua_toboolean(L, lua_upvalueindex(2)) ? 3 : 2;
    lua_Integer from = luaL_optinteger(L, first, 1);
    spend_values(L, range(from, luaL_optinteger(L, first + 1, (lua_Integer)n), n + 1));
    return pass_on(L);
}

static int show(lua_State *L)
{
    luaL_checkany(L, 1);
    script_tostring(L, 1, NULL);
    return 1;
}

// Puts what tostring gives in the place of an argument that %s shows.
static void show_argument(lua_State *L, int index)
{
    if (lua_type(L, index) <= LUA_TSTRING)
        return;
    script_tostring(L, index, NULL);
    lua_replace(L, index);
}

static int guard_format(lua_State *L)
{
    size_t n = 0;
    int index = 1;
    const char *format = luaL_checklstring(L, 1, &n);
    if (lua_gettop(L) > MOST_FORMATTED + 1)
        return luaL_error(L, "format: more than %d values at once", MOST_FORMATTED);
    script_spend(L, n / BYTES_AN_INSTRUCTION);
    for (const char *at = format; at < format + n; ++at) {
        if (*at != '%')
            continue;
        at += 1 + strspn(at + 1, "-+ #0123456789.");
        if (*at == 'p')
            return luaL_error(L, "format: %%p is an address, another one on each run");
        index += *at != '%';
        if (*at == 's' && index <= lua_gettop(L))
            show_argument(L, index);
    }
    return pass_on(L);
}

// (s, what, from, plain): what as it stands, without the characters of patterns
// unless plain allows them.
static int find_plain(lua_State *L)
{
    size_t n = 0, length = 0;
    const char *s = luaL_checklstring(L, 1, &n);
    const char *what = luaL_checklstring(L, 2, &length);
    lua_Integer from = luaL_optinteger(L, 3, 1);
    for (const char *c = "^$*+?.([%-"; *c && !lua_toboolean(L, 4); ++c)
        if (memchr(what, *c, length))
            return luaL_error(L,
                              "find: '%c' makes a pattern, which only 'duet lua --trust' has; "
                              "find(s, text, 1, true) finds plain text",
                              *c);
    from = from < 0 ? from + (lua_Integer)n : from - (from > 0);
    size_t at = from < 0 ? 0 : (size_t)from;
    const char *found = at <= n ? memmem(s + at, n - at, what, length) : NULL;
    size_t end = found ? (size_t)(found - s) + length : n;
    script_spend(L, (range((lua_Integer)at, (lua_Integer)end, n) + length) / BYTES_AN_INSTRUCTION);
    if (!found) {
        lua_pushnil(L);
        return 1;
    }
    lua_pushinteger(L, (lua_Integer)(end - length + 1));
    lua_pushinteger(L, (lua_Integer)end);
    return 2;
}

static int refuse_pattern(lua_State *L)
{
    return luaL_error(L,
                      "%s: only 'duet lua --trust' has patterns; find(s, text, 1, true) finds "
                      "plain text",
                      lua_tostring(L, lua_upvalueindex(1)));
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

static const struct {
    const char *library; // NULL: a global
    const char *name;
    lua_CFunction guard;
    bool kind; // the guard's second upvalue
} guards[] = {
    {NULL, "select", guard_values, false},     {NULL, "tonumber", guard_text, false},
    {NULL, "tostring", show, false},           {"math", "max", guard_values, false},
    {"math", "min", guard_values, false},      {"math", "randomseed", guard_randomseed, false},
    {"string", "byte", guard_values, false},   {"string", "char", guard_values, false},
    {"string", "format", guard_format, false}, {"string", "pack", guard_text, false},
    {"string", "packsize", guard_text, false}, {"string", "rep", guard_rep, false},
    {"string", "unpack", guard_text, false},   {"table", "concat", guard_range, true},
    {"table", "insert", guard_shift, false},   {"table", "pack", guard_values, false},
    {"table", "remove", guard_shift, true},    {"table", "unpack", guard_range, false},
    {"utf8", "char", guard_values, false},     {"utf8", "codepoint", guard_values, false},
    {"utf8", "len", guard_part, false},        {"utf8", "offset", guard_offset, false},
};

// Puts each guard in the place of its function, with that behind it.
static void put_guards(lua_State *L)
{
    for (size_t i = 0; i < sizeof guards / sizeof guards[0]; ++i) {
        lua_pushglobaltable(L);
        if (guards[i].library)
            lua_getfield(L, -1, guards[i].library);
        lua_getfield(L, -1, guards[i].name);
        lua_pushboolean(L, guards[i].kind);
        lua_pushcclosure(L, guards[i].guard, 2);
        lua_setfield(L, -2, guards[i].name);
        lua_settop(L, 0);
    }
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

// The functions that take a pattern, each with its name behind it.
static void replace_patterns(lua_State *L)
{
    static const luaL_Reg functions[] = {{"find", find_plain},
                                         {"gmatch", refuse_pattern},
                                         {"gsub", refuse_pattern},
                                         {"match", refuse_pattern}};
    lua_getglobal(L, "string");
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i) {
        lua_pushstring(L, functions[i].name);
        lua_pushcclosure(L, functions[i].func, 1);
        lua_setfield(L, -2, functions[i].name);
    }
    lua_pop(L, 1);
}

static void open_guards(lua_State *L)
{
    remove_field(L, "string", "dump");
    put_guards(L);
    replace_patterns(L);
    lua_register(L, "assert", place_assert);
}

static int kind_of(lua_State *L, int index)
{
    int type = lua_type(L, index);
    return type == LUA_TNUMBER ? 1 : type == LUA_TSTRING ? 2 : type == LUA_TBOOLEAN ? 3 : 4;
}

// Whether the key at 1 comes before the one at 2: numbers, then strings by
// their bytes, whatever the locale is, then false and true.
static int key_before(lua_State *L)
{
    int kind = kind_of(L, 1);
    int before = kind < kind_of(L, 2);
    if (kind == kind_of(L, 2) && kind == 1)
        before = lua_compare(L, 1, 2, LUA_OPLT);
    if (kind == kind_of(L, 2) && kind == 2) {
        size_t n = lua_rawlen(L, 1);
        size_t m = lua_rawlen(L, 2);
        int order = memcmp(lua_tostring(L, 1), lua_tostring(L, 2), n < m ? n : m);
        before = order < 0 || (order == 0 && n < m);
    }
    if (kind == kind_of(L, 2) && kind == 3)
        before = lua_toboolean(L, 2) && !lua_toboolean(L, 1);
    lua_pushboolean(L, before);
    return 1;
}

// The part of the sandbox that is written in Lua itself.
static void open_lua_part(lua_State *L)
{
    const blob *part = blob_find("gen/sandbox.lua");
    if (luaL_loadbufferx(L, part->bytes, part->length, "=gen/sandbox.lua", "t") != LUA_OK)
        lua_error(L);
    lua_pushcfunction(L, key_before);
    lua_call(L, 1, 0);
}

static int open_globals(lua_State *L)
{
    open_base(L);
    open_libraries(L);
    open_guards(L);
    open_lua_part(L);
    return 0;
}

script *sandbox_open(const script_limits *limits, duet_error *err)
{
    script *s = script_open(limits, err);
    if (!s)
        return NULL;
    lua_pushcfunction(script_lua(s), open_globals);
    if (script_call(s, 0, 0, err))
        return s;
    script_close(s);
    return NULL;
}
