// SPDX-License-Identifier: MIT
#include "runtime/task/task_reference.h"

#include "base/error.h"
#include "base/text_file.h"
#include "gen/field.h"
#include "gen/script.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <stdio.h>
#include <string.h>

bool task_expect_initial(task *t, duet_error *err)
{
    for (uint32_t i = 0; i < t->n_args; ++i) {
        task_arg *arg = &t->args[i];
        if (!task_arg_is_written(arg) || arg->expected.bytes)
            continue;
        if (!task_values_make(&arg->expected, arg->initial.scalar, arg->initial.n, err))
            return false;
        memcpy(arg->expected.bytes, arg->initial.bytes, arg->initial.size);
    }
    return true;
}

// ---------------------------------------------------------------- numbers

static bool holds(task_scalar scalar, int64_t value)
{
    static const struct {
        int64_t least, most;
    } ranges[] = {
        [TASK_CHAR] = {INT8_MIN, INT8_MAX},    [TASK_UCHAR] = {0, UINT8_MAX},
        [TASK_SHORT] = {INT16_MIN, INT16_MAX}, [TASK_USHORT] = {0, UINT16_MAX},
        [TASK_INT] = {INT32_MIN, INT32_MAX},   [TASK_UINT] = {0, UINT32_MAX},
        [TASK_LONG] = {INT64_MIN, INT64_MAX},  [TASK_ULONG] = {INT64_MIN, INT64_MAX},
    };
    return value >= ranges[scalar].least && value <= ranges[scalar].most;
}

bool task_values_put(task_values *v, uint64_t i, lua_State *L, int index)
{
    if (lua_type(L, index) != LUA_TNUMBER)
        return false;
    if (!task_scalar_is_whole(v->scalar)) {
        task_values_set(v, i, lua_tonumber(L, index));
        return true;
    }
    int is_whole = 0;
    int64_t whole = lua_tointegerx(L, index, &is_whole);
    if (!is_whole || !holds(v->scalar, whole))
        return false;
    task_values_set_whole(v, i, whole);
    return true;
}

// ---------------------------------------------------------------- arrays in Lua

// An array of the task as the script sees it: a.x[0] to a.x[#a.x - 1].
typedef struct array_view {
    task_values *values;
    const task_arg *arg;
    bool is_written;
} array_view;

static uint64_t check_index(lua_State *L, const array_view *s)
{
    int is_whole = 0;
    int64_t i = lua_tointegerx(L, 2, &is_whole);
    if (!is_whole || i < 0 || (uint64_t)i >= s->values->n)
        luaL_error(L, "%s[%s]: expected 0 to %I", s->arg->name, script_tostring(L, 2, NULL),
                   (LUAI_UACINT)s->values->n - 1);
    return (uint64_t)i;
}

static int get_number(lua_State *L)
{
    const array_view *s = lua_touserdata(L, 1);
    uint64_t i = check_index(L, s);
    if (task_scalar_is_whole(s->values->scalar))
        lua_pushinteger(L, task_values_get_whole(s->values, i));
    else
        lua_pushnumber(L, task_values_get(s->values, i));
    return 1;
}

static int set_number(lua_State *L)
{
    array_view *s = lua_touserdata(L, 1);
    uint64_t i = check_index(L, s);
    if (!s->is_written)
        return luaL_error(L, "%s is only read: its access is %s", s->arg->name,
                          task_access_name(s->arg->access));
    if (!task_values_put(s->values, i, L, 3))
        return luaL_error(L, "%s[%I] = %s: expected a number that %s holds", s->arg->name,
                          (LUAI_UACINT)i, script_tostring(L, 3, NULL), s->arg->type);
    return 0;
}

static int count_numbers(lua_State *L)
{
    const array_view *s = lua_touserdata(L, 1);
    lua_pushinteger(L, (lua_Integer)s->values->n);
    return 1;
}

static void push_array(lua_State *L, task_arg *arg)
{
    static const luaL_Reg methods[] = {{"__index", get_number},
                                       {"__newindex", set_number},
                                       {"__len", count_numbers},
                                       {NULL, NULL}};
    bool is_written = task_arg_is_written(arg);
    array_view *s = lua_newuserdatauv(L, sizeof *s, 0);
    *s = (array_view){is_written ? &arg->expected : &arg->initial, arg, is_written};
    luaL_newlib(L, methods);
    lua_setmetatable(L, -2);
}

// {x = array, a = 2.0, items = n}
static void push_args(lua_State *L, task *t)
{
    lua_newtable(L);
    lua_pushinteger(L, (lua_Integer)t->items);
    lua_setfield(L, -2, "items");
    for (uint32_t i = 0; i < t->n_args; ++i) {
        task_arg *arg = &t->args[i];
        if (arg->kind == TASK_ARG_ARRAY)
            push_array(L, arg);
        else if (arg->kind == TASK_ARG_WHOLE)
            lua_pushinteger(L, arg->whole);
        else
            lua_pushnumber(L, arg->value);
        lua_setfield(L, -2, arg->name);
    }
}

// ---------------------------------------------------------------- reading

// The only array that is written; a file has the numbers of one.
static task_arg *find_written(lua_State *L, task *t)
{
    task_arg *written = NULL;
    for (uint32_t i = 0; i < t->n_args; ++i) {
        if (!task_arg_is_written(&t->args[i]))
            continue;
        if (written)
            field_raise(L, "reference",
                        "reference is a file, but %s and %s are written; expected one array",
                        written->name, t->args[i].name);
        written = &t->args[i];
    }
    return written;
}

// A file beside the task's: its numbers as the machine has them, nothing before or behind.
static void read_file(lua_State *L, task *t, const char *name, duet_error *why)
{
    task_arg *arg = find_written(L, t);
    text path = {0}, bytes = {0};
    if (!t->folder)
        field_raise(L, "reference",
                    "reference is '%.80s', but the task has no folder; expected a kernel's name",
                    name);
    if (strchr(name, '/'))
        field_raise(L, "reference", "reference is '%.80s'; expected a file beside the task's",
                    name);
    text_add(&path, "%s/%s", t->folder, name);
    bool ok = text_ok(&path, why) && text_read_file(&bytes, text_chars(&path), why);
    size_t length = bytes.length;
    if (ok && length == arg->expected.size)
        memcpy(arg->expected.bytes, bytes.chars, length);
    text_free(&path);
    text_free(&bytes);
    if (!ok)
        field_raise(L, "reference", "reference: %s", why->text);
    if (length != arg->expected.size)
        field_raise(L, "reference", "reference: %.80s has %zu bytes; expected %zu, as %s has", name,
                    length, arg->expected.size, arg->name);
}

void task_reference_read(lua_State *L, int root, task *t, duet_error *why)
{
    int type = lua_getfield(L, root, "reference");
    const char *name = field_text(L, -1);
    if (type == LUA_TNIL) {
        snprintf(t->reference, sizeof t->reference, "%s", t->kernel);
    } else if (name && strcmp(name, t->kernel) == 0) {
        field_raise(L, "reference",
                    "reference is '%s', the task's own kernel; expected another kernel's name, or "
                    "nothing to check sharing alone",
                    name);
    } else if (name && !strchr(name, '.') && *name && strlen(name) < sizeof t->reference) {
        snprintf(t->reference, sizeof t->reference, "%s", name);
    } else if (type == LUA_TFUNCTION || name) {
        if (!task_expect_initial(t, why))
            luaL_error(L, "reference: %s", why->text);
        if (name) {
            read_file(L, t, name, why);
            return;
        }
        push_args(L, t);
        lua_call(L, 1, 0);
    } else {
        field_raise(L, "reference",
                    "reference is %s; expected a function, a kernel's name or a file's",
                    field_push_shown(L, -1));
    }
}
