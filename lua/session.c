// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "lua/session.h"

#include "base/budget.h"
#include "base/text_file.h"
#include "duet_lua.h"
#include "gen/sandbox.h"
#include "lua/nouns.h"
#include "lua/policy.h"

#include <lauxlib.h>
#include <lualib.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// How often a trusted script is asked whether to stop, in instructions.
#define HOOK_INSTRUCTIONS 10000

struct session {
    session_def def;
    script *script; // NULL if trusted
    lua_State *lua; // the script's, or one of its own
};

// In the registry: the functions of the prompt.
static const char show_key = 0;
static const char complete_key = 0;

session_def session_default_def(void)
{
    return (session_def){.memory_bytes = (size_t)256 << 20, .seconds = 60};
}

// ---------------------------------------------------------------- calls

// Makes a line of the error value and takes it off the stack.
static bool fail(session *s, duet_error *err)
{
    text shown = {0};
    size_t n = 0;
    const char *message = lua_tolstring(s->lua, -1, &n);
    if (message)
        text_add_visible(&shown, message, n, "\n\r\t");
    bad_input(err, "%s", message ? text_chars(&shown) : "an error that is not a text");
    text_free(&shown);
    lua_pop(s->lua, 1);
    return false;
}

static bool load(session *s, const char *name, const char *chars, size_t n, duet_error *err)
{
    if (s->script)
        return script_load(s->script, name, chars, n, err);
    text at_name = {0}; // "@path" is how Lua knows a file from a text
    text_add(&at_name, "@%s", name);
    bool ok = text_ok(&at_name, err);
    ok = ok && (luaL_loadbufferx(s->lua, chars, n, at_name.chars, "t") == LUA_OK || fail(s, err));
    text_free(&at_name);
    return ok;
}

// The global of the whole language whose lack a message tells of; NULL: none.
static const char *find_missing(const char *says)
{
    static const char *const names[] = {
        "collectgarbage", "coroutine", "debug",        "dofile",  "getmetatable", "io",
        "load",           "loadfile",  "os",           "package", "rawequal",     "rawget",
        "rawlen",         "rawset",    "setmetatable", "warn",    "pcall",        "xpcall"};
    char lack[64];
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        snprintf(lack, sizeof lack, "a nil value (global '%s')", names[i]);
        if (strstr(says, lack))
            return names[i];
    }
    return NULL;
}

static bool call_untrusted(session *s, int n_arguments, int n_results, duet_error *err)
{
    duet_error why = {0};
    if (script_call(s->script, n_arguments, n_results, &why))
        return true;
    const char *missing = find_missing(why.text);
    return missing
               ? error_set(err, why.status, "%s; 'duet lua --trust' gives '%s'", why.text, missing)
               : error_copy(err, &why);
}

static bool call(session *s, int n_arguments, int n_results, duet_error *err)
{
    if (s->script)
        return call_untrusted(s, n_arguments, n_results, err);
    budget none = {.deadline_ns = UINT64_MAX, .host_bytes = SIZE_MAX};
    budget_enter(&none);
    int status = lua_pcall(s->lua, n_arguments, n_results, 0);
    budget_leave(&none);
    return status == LUA_OK || fail(s, err);
}

static void on_count(lua_State *L, lua_Debug *ar)
{
    (void)ar;
    duet_error why = {0};
    if (!budget_check(&why))
        luaL_error(L, "%s", why.text);
}

// ---------------------------------------------------------------- globals

// Control characters that an untrusted script prints do not reach the terminal.
static void print_chars(const char *chars, size_t n)
{
    text shown = {0};
    if (isatty(STDOUT_FILENO))
        text_add_visible(&shown, chars, n, "\n\t");
    else
        text_add_bytes(&shown, chars, n);
    fwrite(text_chars(&shown), 1, shown.length, stdout);
    text_free(&shown);
}

static int print(lua_State *L)
{
    for (int i = 1, n = lua_gettop(L); i <= n; ++i) {
        size_t length = 0;
        const char *chars = script_tostring(L, i, &length);
        fwrite(i > 1 ? "\t" : "", 1, i > 1, stdout);
        print_chars(chars, length);
        lua_pop(L, 1);
    }
    fputc('\n', stdout);
    return 0;
}

// Without --trust there is no other module.
static int require(lua_State *L)
{
    if (strcmp(luaL_checkstring(L, 1), "duet") != 0)
        return luaL_error(L, "require '%s': without --trust there is only 'duet'",
                          lua_tostring(L, 1));
    lua_getglobal(L, "duet");
    return 1;
}

static void set_arg(lua_State *L, const session_def *def)
{
    lua_newtable(L);
    for (int i = 0; i < def->n_arguments; ++i) {
        lua_pushstring(L, def->arguments[i]);
        lua_rawseti(L, -2, i);
    }
    lua_setglobal(L, "arg");
}

// Loads what shows and completes typed words, and the global help.
static void load_prompt(lua_State *L)
{
    load_carried(L, "lua/show.lua");
    lua_pushcfunction(L, class_names);
    lua_call(L, 1, 2); // show, is_name
    load_carried(L, "lua/prompt.lua");
    lua_insert(L, -2);
    lua_pushcfunction(L, class_names);
    load_carried(L, "lua/api.lua");
    lua_call(L, 0, 1);
    lua_call(L, 3, 2);
    lua_setglobal(L, "help");
    lua_rawsetp(L, LUA_REGISTRYINDEX, &complete_key);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &show_key);
}

// os.execute, which lets no signal for the terminal through: what ends the command is
// meant for the script too. Upvalue 1 is Lua's own.
static int execute(lua_State *L)
{
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    bool by_signal = lua_gettop(L) == 3 && strcmp(lua_tostring(L, 2), "signal") == 0;
    if (by_signal && lua_tointeger(L, 3) == SIGINT)
        raise(SIGINT);
    return lua_gettop(L);
}

static void open_libraries(lua_State *L)
{
    luaL_openlibs(L);
    lua_getglobal(L, LUA_OSLIBNAME);
    lua_getfield(L, -1, "execute");
    lua_pushcclosure(L, execute, 1);
    lua_setfield(L, -2, "execute");
    lua_pop(L, 1);
}

// A C function: fills the globals of the session at 1.
static int prepare(lua_State *L)
{
    const session *s = lua_touserdata(L, 1);
    if (s->script) {
        lua_register(L, "print", print);
        lua_register(L, "require", require);
        lua_pushcfunction(L, luaopen_duet);
        lua_call(L, 0, 1);
        lua_setglobal(L, "duet");
        policy_restrict(L, s->def.arguments, s->def.n_arguments);
    } else {
        open_libraries(L);
        luaL_requiref(L, "duet", luaopen_duet, 1);
    }
    set_arg(L, &s->def);
    if (s->def.prompt)
        load_prompt(L);
    return 0;
}

// ---------------------------------------------------------------- sessions

static bool open_state(session *s, duet_error *err)
{
    if (s->def.trusted) {
        s->lua = luaL_newstate();
        if (!s->lua)
            return no_memory(err, "a Lua state");
        lua_sethook(s->lua, on_count, LUA_MASKCOUNT, HOOK_INSTRUCTIONS);
        return true;
    }
    script_limits limits = script_default_limits();
    limits.memory_bytes = limits.host_bytes = s->def.memory_bytes;
    limits.seconds = s->def.seconds;
    limits.instructions = UINT64_MAX / 2; // the seconds count
    s->script = sandbox_open(&limits, err);
    s->lua = s->script ? script_lua(s->script) : NULL;
    return s->script != NULL;
}

session *session_open(const session_def *def, duet_error *err)
{
    session *s = calloc(1, sizeof *s);
    if (!s)
        return null_no_memory(err, "a Lua state");
    s->def = *def;
    bool ok = open_state(s, err);
    if (ok) {
        lua_pushcfunction(s->lua, prepare);
        lua_pushlightuserdata(s->lua, s);
        ok = call(s, 1, 0, err);
    }
    if (!ok) {
        session_close(s);
        return NULL;
    }
    return s;
}

void session_close(session *s)
{
    if (!s)
        return;
    if (s->script)
        script_close(s->script);
    else if (s->lua)
        lua_close(s->lua);
    free(s);
}

bool session_run_text(session *s, const char *name, const char *chars, duet_error *err)
{
    return load(s, name, chars, strlen(chars), err) && call(s, 0, 0, err);
}

bool session_run_file(session *s, const char *path, duet_error *err)
{
    text chars = {0};
    bool ok = text_read_lines(&chars, path, err);
    if (ok && chars.length > 0 && chars.chars[0] == '#')
        memcpy(chars.chars, "--", chars.length > 1 ? 2 : 1);
    ok = ok && load(s, strcmp(path, "-") == 0 ? "stdin" : path, chars.chars, chars.length, err) &&
         call(s, 0, 0, err);
    text_free(&chars);
    return ok;
}

// ---------------------------------------------------------------- typing

static bool is_beginning(const duet_error *err)
{
    const char *end = "near <eof>";
    size_t length = strlen(err->text);
    return length >= strlen(end) && strcmp(err->text + length - strlen(end), end) == 0;
}

// An expression is tried first, since most of what is typed is one.
static bool load_typed(session *s, const char *chars, bool *more, duet_error *err)
{
    duet_error why = {0};
    text expression = {0};
    text_add(&expression, "return %s", chars);
    bool ok = text_ok(&expression, err);
    if (ok && !load(s, "typed", expression.chars, expression.length, &why)) {
        bool begins_expression = is_beginning(&why);
        why = (duet_error){0};
        ok = load(s, "typed", chars, strlen(chars), &why);
        *more = !ok && (begins_expression || is_beginning(&why));
        if (!ok && !*more)
            *err = why;
    }
    text_free(&expression);
    return ok;
}

// "help" alone is a call of it.
static bool asks_for_help(const char *chars)
{
    size_t before = strspn(chars, " \t");
    size_t after = strspn(chars + before + strcspn(chars + before, " \t"), " \t");
    return strncmp(chars + before, "help", 4) == 0 && strlen(chars + before) == 4 + after;
}

// show(results...) under the results of a call, the number of which varies.
static bool show_results(session *s, int top, duet_error *err)
{
    int n = lua_gettop(s->lua) - top;
    if (n == 0)
        return true;
    lua_rawgetp(s->lua, LUA_REGISTRYINDEX, &show_key);
    lua_insert(s->lua, top + 1);
    return call(s, n, 0, err);
}

bool session_enter(session *s, const char *chars, bool *more, duet_error *err)
{
    *more = false;
    int top = lua_gettop(s->lua);
    if (!load_typed(s, asks_for_help(chars) ? "help()" : chars, more, err))
        return *more;
    return call(s, 0, LUA_MULTRET, err) && show_results(s, top, err);
}

bool session_complete(session *s, const char *word, text *words)
{
    duet_error err = {0};
    lua_rawgetp(s->lua, LUA_REGISTRYINDEX, &complete_key);
    lua_pushstring(s->lua, word);
    lua_pushglobaltable(s->lua);
    if (!call(s, 2, 1, &err))
        return false;
    text_add(words, "%s", lua_tostring(s->lua, -1));
    lua_pop(s->lua, 1);
    return text_ok(words, NULL);
}
