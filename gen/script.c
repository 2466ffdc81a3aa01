// SPDX-License-Identifier: MIT
// The limits and the errors of a private Lua state. What a script finds in it
// is sandbox.c's.
#include "gen/script.h"
#include "gen/sandbox.h"
#include "runtime/base/clock.h"
#include "runtime/base/text.h"

#include <lauxlib.h>
#include <stdlib.h>
#include <string.h>

// How often the limits are looked at, in instructions.
#define HOOK_INSTRUCTIONS 256

struct script {
    lua_State *lua;
    script_limits limits;
    size_t used_bytes;
    uint64_t instructions_left; // of the running call
    uint64_t deadline_ns;
    int depth;   // calls inside calls; the outermost one sets the limits
    int line;    // where memory ran out last; 0: outside of any script
    text name;   // of the chunk loaded last
    text source; // its text
};

script_limits script_default_limits(void)
{
    return (script_limits){
        .memory_bytes = (size_t)64 << 20, .instructions = 100000000, .seconds = 10};
}

// ---------------------------------------------------------------- limits

// The innermost line of a script. Lua says none itself where memory ran out;
// neither call here allocates.
static int find_line(lua_State *L)
{
    lua_Debug ar;
    for (int level = 0; lua_getstack(L, level, &ar); ++level)
        if (lua_getinfo(L, "l", &ar) && ar.currentline > 0)
            return ar.currentline;
    return 0;
}

static void *refuse_memory(script *s)
{
    s->line = s->lua ? find_line(s->lua) : 0;
    return NULL;
}

static void *allocate(void *data, void *at, size_t old_bytes, size_t bytes)
{
    script *s = data;
    if (!at)
        old_bytes = 0; // Lua passes the kind of object there
    if (bytes == 0) {
        free(at);
        s->used_bytes -= old_bytes;
        return NULL;
    }
    if (bytes > old_bytes && bytes - old_bytes > s->limits.memory_bytes - s->used_bytes)
        return refuse_memory(s);
    void *moved = realloc(at, bytes);
    if (!moved)
        return NULL;
    s->used_bytes = s->used_bytes - old_bytes + bytes;
    return moved;
}

static script *script_of(lua_State *L)
{
    return *(script **)lua_getextraspace(L);
}

static bool spend(script *s, uint64_t instructions)
{
    bool enough = instructions < s->instructions_left;
    s->instructions_left = enough ? s->instructions_left - instructions : 0;
    return enough && clock_steady_ns() <= s->deadline_ns;
}

// level: who is to blame, in frames above the running function.
static void raise_limit(lua_State *L, int level)
{
    const script *s = script_of(L);
    luaL_where(L, level);
    if (s->instructions_left == 0)
        lua_pushfstring(L, "runs for more than the %I instructions it may take",
                        (LUAI_UACINT)s->limits.instructions);
    else
        lua_pushfstring(L, "runs for more than the %f seconds it may take",
                        (LUAI_UACNUMBER)s->limits.seconds);
    lua_concat(L, 2);
    lua_error(L);
}

void script_spend(lua_State *L, uint64_t instructions)
{
    if (!spend(script_of(L), instructions))
        raise_limit(L, 1);
}

static void on_count(lua_State *L, lua_Debug *ar)
{
    (void)ar;
    const script_limits *limits = &script_of(L)->limits;
    if (limits->stopped && limits->stopped())
        luaL_error(L, "stopped");
    if (!spend(script_of(L), HOOK_INSTRUCTIONS))
        raise_limit(L, 0);
}

static void begin_limits(script *s)
{
    if (s->depth++ > 0)
        return;
    s->instructions_left = s->limits.instructions;
    s->deadline_ns = clock_steady_ns() + (uint64_t)(s->limits.seconds * 1e9);
    lua_sethook(s->lua, on_count, LUA_MASKCOUNT, HOOK_INSTRUCTIONS);
}

static void end_limits(script *s)
{
    if (--s->depth == 0)
        lua_sethook(s->lua, NULL, 0, 0);
}

// ---------------------------------------------------------------- errors

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
// The rest of the message after that end, or NULL where it does not begin so.
static const char *after_cut_name(const char *message, const text *name)
{
    size_t kept = LUA_IDSIZE - 1 - 3;
    if (strncmp(message, "...", 3) != 0 || name->length < LUA_IDSIZE - 1)
        return NULL;
    bool same = strncmp(message + 3, name->chars + name->length - kept, kept) == 0;
    return same ? message + 3 + kept : NULL;
}

// Takes the error value off the stack and makes a line of it.
static bool fail(script *s, int lua_status, duet_error *err)
{
    const char *name = text_chars(&s->name);
    bool is_text = lua_type(s->lua, -1) == LUA_TSTRING;
    const char *message = is_text ? lua_tostring(s->lua, -1) : "";
    duet_status status = s->limits.failure ? s->limits.failure : DUET_BAD_INPUT;
    const char *rest = after_cut_name(message, &s->name);
    if (lua_status == LUA_ERRMEM)
        error_set(err, status, "%s:%d: needs more than the %zu KiB of memory it may take", name,
                  s->line, s->limits.memory_bytes >> 10);
    else if (!is_text)
        error_set(err, status, "%s: raises a %s as its error, not a line of text", name,
                  luaL_typename(s->lua, -1));
    else if (rest)
        error_set(err, status, "%s%s", name, rest);
    else if (has_place(message, &s->name))
        error_set(err, status, "%s", message);
    else
        error_set(err, status, "%s: %s", name, message);
    lua_pop(s->lua, 1);
    return false;
}

// ---------------------------------------------------------------- calls

script *script_open(const script_limits *limits, duet_error *err)
{
    script *s = calloc(1, sizeof *s);
    if (!s) {
        error_set(err, DUET_NO_MEMORY, "a Lua state: no memory");
        return NULL;
    }
    s->limits = limits ? *limits : script_default_limits();
    text_add(&s->name, "the sandbox");
    s->lua = lua_newstate(allocate, s);
    if (!s->lua) {
        error_set(err, DUET_NO_MEMORY, "a Lua state in %zu bytes: no memory",
                  s->limits.memory_bytes);
        script_close(s);
        return NULL;
    }
    *(script **)lua_getextraspace(s->lua) = s;
    lua_pushcfunction(s->lua, sandbox_open);
    if (!script_call(s, 0, 0, err)) {
        script_close(s);
        return NULL;
    }
    return s;
}

void script_close(script *s)
{
    if (!s)
        return;
    if (s->lua)
        lua_close(s->lua);
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

bool script_load(script *s, const char *name, const char *chars, size_t n, duet_error *err)
{
    text at_name = {0}; // "@path" is how Lua knows a file from a text
    text_add(&at_name, "@%s", name);
    bool ok = text_ok(&at_name, err) && remember_chunk(s, name, chars, n, err);
    if (ok) {
        int status = luaL_loadbufferx(s->lua, chars, n, at_name.chars, "t");
        ok = status == LUA_OK || fail(s, status, err);
    }
    text_free(&at_name);
    return ok;
}

bool script_call(script *s, int n_args, int n_results, duet_error *err)
{
    begin_limits(s);
    int status = lua_pcall(s->lua, n_args, n_results, 0);
    end_limits(s);
    return status == LUA_OK || fail(s, status, err);
}

bool script_run(script *s, const char *name, const char *chars, size_t n, int n_results,
                duet_error *err)
{
    return script_load(s, name, chars, n, err) && script_call(s, 0, n_results, err);
}

bool script_run_file(script *s, const char *path, int n_results, duet_error *err)
{
    text chars = {0};
    bool ok = text_read_file(&chars, path, err) &&
              script_run(s, path, chars.chars, chars.length, n_results, err);
    text_free(&chars);
    return ok;
}

const char *script_chunk(lua_State *L, const char **name)
{
    const script *s = script_of(L);
    *name = text_chars(&s->name);
    return text_chars(&s->source);
}
