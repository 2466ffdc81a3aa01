// SPDX-License-Identifier: MIT
// The calls and the errors of a private Lua state.
#define _GNU_SOURCE // memmem
#include "gen/script_state.h"

#include "base/clock.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// How much text the parser gets at a time: with deep functions inside others
// each of its names costs microseconds.
#define PIECE_BYTES 512

enum { MOST_JUMPS = 10000 }; // goto and break in a text

script_limits script_default_limits(void)
{
    return (script_limits){
        .memory_bytes = (size_t)64 << 20, .instructions = 100000000, .seconds = 10};
}

// ---------------------------------------------------------------- errors

duet_status script_set_failure(lua_State *L, duet_status status)
{
    script *s = script_of(L);
    duet_status before = s->limits.failure;
    s->limits.failure = status;
    return before;
}

// "name: ..." or "...:12:..."
static bool has_place(const char *message, const text *name)
{
    if (strncmp(message, name->chars, name->length) == 0 && message[name->length] == ':')
        return true;
    for (const char *at = strchr(message, ':'); at; at = strchr(at + 1, ':')) {
        size_t digits = strspn(at + 1, "0123456789");
        if (digits > 0 && at[1 + digits] == ':')
            return true;
    }
    return false;
}

// Lua keeps only the end of a long chunk name: "...end/of/path.lua:12: ...".
// The rest of the message after that end, or NULL if it does not begin so.
static const char *after_cut_name(const char *message, const text *name)
{
    size_t kept = LUA_IDSIZE - 1 - 3;
    if (strncmp(message, "...", 3) != 0 || name->length < LUA_IDSIZE - 1)
        return NULL;
    bool same = strncmp(message + 3, name->chars + name->length - kept, kept) == 0;
    return same ? message + 3 + kept : NULL;
}

// The limit that the running call has passed, as a line.
static bool report_limit(script *s, duet_status status, duet_error *err)
{
    const char *place = *s->place ? s->place : s->name.chars;
    if (s->passed == STOP)
        return error_set(err, DUET_STATUS_INTERRUPTED, "%s: stopped", place);
    if (s->passed == HOST_MEMORY)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory", place);
    if (s->passed == INSTRUCTIONS)
        return error_set(err, status,
                         "%s: runs for more than the %" PRIu64 " instructions it may take", place,
                         s->limits.instructions);
    if (s->passed == TIME)
        return error_set(err, status, "%s: runs for more than the %g s it may take", place,
                         s->budget.seconds);
    return error_set(err, status, "%s: needs more than the %s of memory it may take", place,
                     budget_memory(s->limits.memory_bytes).chars);
}

// Adds the text on top of the stack, also behind a NUL.
static void add_message(text *t, lua_State *L)
{
    size_t n = 0;
    const char *chars = lua_tolstring(L, -1, &n);
    text_add_visible(t, chars, n, "\n\r\t");
}

// Takes the error value off the stack and makes a line of it.
static bool fail(script *s, int lua_status, duet_error *err)
{
    const char *name = s->name.chars;
    bool is_text = lua_type(s->lua, -1) == LUA_TSTRING;
    text shown = {0};
    if (is_text)
        add_message(&shown, s->lua);
    const char *message = text_chars(&shown);
    duet_status status = s->limits.failure;
    const char *rest = after_cut_name(message, &s->name);
    if (lua_status == LUA_ERRMEM || s->passed)
        report_limit(s, status, err);
    else if (!is_text)
        error_set(err, status, "%s: raises a %s as its error, not a line of text", name,
                  luaL_typename(s->lua, -1));
    else if (rest)
        error_set(err, status, "%s%s", name, rest);
    else if (has_place(message, &s->name))
        error_set(err, status, "%s", message);
    else
        error_set(err, status, "%s: %s", name, message);
    text_free(&shown);
    lua_pop(s->lua, 1);
    return false;
}

// ---------------------------------------------------------------- calls

script *script_open(const script_limits *limits, duet_error *err)
{
    script *s = calloc(1, sizeof *s);
    if (!s)
        return null_no_memory(err, "a Lua state");
    s->limits = limits ? *limits : script_default_limits();
    if (!s->limits.failure)
        s->limits.failure = DUET_STATUS_BAD_INPUT;
    text_add(&s->name, "the sandbox");
    s->lua = text_ok(&s->name, err) ? lua_newstate(script_allocate, s) : NULL;
    if (s->lua)
        return s;
    no_memory(err, "a Lua state in %zu bytes", s->limits.memory_bytes);
    script_close(s);
    return NULL;
}

void script_close(script *s)
{
    if (!s)
        return;
    if (s->lua) {
        s->budget.deadline_ns = clock_steady_ns() + s->left_ns;
        budget_enter(&s->budget);
        lua_close(s->lua);
        budget_leave(&s->budget);
    }
    text_free(&s->name);
    text_free(&s->source);
    free(s);
}

lua_State *script_lua(script *s)
{
    return s->lua;
}

static bool remember_chunk(script *s, const char *name, const char *chars, size_t n,
                           duet_error *err)
{
    s->name.length = s->source.length = 0;
    text_add(&s->name, "%s", name);
    text_add_bytes(&s->source, chars, n);
    return text_ok(&s->name, err) && text_ok(&s->source, err);
}

static size_t count_words(const char *chars, size_t n, const char *word)
{
    size_t count = 0;
    size_t length = strlen(word);
    const char *end = chars + n;
    for (; (chars = memmem(chars, (size_t)(end - chars), word, length)); chars += length)
        ++count;
    return count;
}

// The parser joins n jumps to one label in n^2 steps, at a single word of the
// text: 10000 of them take 0.2 s.
static bool check_jumps(const script *s, const char *chars, size_t n, duet_error *err)
{
    size_t jumps = count_words(chars, n, "goto") + count_words(chars, n, "break");
    return jumps <= MOST_JUMPS || error_set(err, s->limits.failure,
                                            "%s: has goto or break %zu times, where %d are allowed",
                                            s->name.chars, jumps, MOST_JUMPS);
}

typedef struct pieces {
    const char *chars;
    size_t left;
} pieces;

// A lua_Reader.
static const char *read_piece(lua_State *L, void *data, size_t *n)
{
    pieces *p = data;
    const char *chars = p->chars;
    script_look(L);
    *n = p->left < PIECE_BYTES ? p->left : PIECE_BYTES;
    p->chars += *n;
    p->left -= *n;
    return chars;
}

bool script_load(script *s, const char *name, const char *chars, size_t n, duet_error *err)
{
    text at_name = {0}; // "@path" is how Lua knows a file from a text
    text_add(&at_name, "@%s", name);
    bool ok = text_ok(&at_name, err) && remember_chunk(s, name, chars, n, err) &&
              check_jumps(s, chars, n, err);
    if (ok) {
        pieces p = {chars, n};
        script_begin(s);
        int status = lua_load(s->lua, read_piece, &p, at_name.chars, "t");
        script_end(s);
        ok = status == LUA_OK || fail(s, status, err);
    }
    text_free(&at_name);
    return ok;
}

bool script_call(script *s, int n_args, int n_results, duet_error *err)
{
    script_begin(s);
    int status = lua_pcall(s->lua, n_args, n_results, 0);
    script_end(s);
    return status == LUA_OK || fail(s, status, err);
}

bool script_run(script *s, const char *name, const char *chars, size_t n, int n_results,
                duet_error *err)
{
    script_begin(s);
    bool ok = script_load(s, name, chars, n, err) && script_call(s, 0, n_results, err);
    script_end(s);
    return ok;
}

// ---------------------------------------------------------------- names

// The registry's table of the objects that were shown, with their numbers.
static const char shown_key = 0;

// Its keys are weak, so that it keeps nothing alive.
static void push_shown(lua_State *L)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &shown_key) == LUA_TTABLE)
        return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "k");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &shown_key);
}

static lua_Integer number_of(lua_State *L, int index)
{
    script *s = script_of(L);
    push_shown(L);
    lua_pushvalue(L, index);
    if (lua_rawget(L, -2) == LUA_TNIL) {
        lua_pushvalue(L, index);
        lua_pushinteger(L, ++s->n_shown);
        lua_rawset(L, -4);
        lua_pop(L, 1);
        lua_pushinteger(L, s->n_shown);
    }
    lua_Integer number = lua_tointeger(L, -1);
    lua_pop(L, 2);
    return number;
}

const char *script_tostring(lua_State *L, int index, size_t *length)
{
    index = lua_absindex(L, index);
    bool is_plain = lua_type(L, index) <= LUA_TSTRING && lua_type(L, index) != LUA_TLIGHTUSERDATA;
    if (is_plain || luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
        lua_settop(L, lua_gettop(L) - !is_plain);
        return luaL_tolstring(L, index, length);
    }
    lua_pushfstring(L, "%s: %I", luaL_typename(L, index), (LUAI_UACINT)number_of(L, index));
    return lua_tolstring(L, -1, length);
}

const char *script_chunk(lua_State *L, const char **name)
{
    const script *s = script_of(L);
    if (!s)
        return NULL;
    *name = s->name.chars;
    return text_chars(&s->source);
}
