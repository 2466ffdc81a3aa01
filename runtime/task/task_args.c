// SPDX-License-Identifier: MIT
#include "runtime/task/task_args.h"

#include "base/error.h"
#include "base/rng.h"
#include "gen/field.h"
#include "gen/script.h"
#include "runtime/task/task_reference.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reading {
    task *task;
    uint64_t seed;
    duet_error *why;
} reading;

// ---------------------------------------------------------------- fields of an argument

// The argument's table is on top of the stack here.

// Pushes a field; a number selects from the list.
static int push_field(lua_State *L, const char *field, int index)
{
    return field ? lua_getfield(L, -1, field) : lua_rawgeti(L, -1, index);
}

// Reads a whole number from `least` to `most`; the fallback if it is not given.
static uint64_t read_whole(lua_State *L, const task_arg *arg, const char *field, int index,
                           int64_t least, int64_t most, int64_t fallback)
{
    int is_whole = 0;
    int type = push_field(L, field, index);
    int64_t value = lua_tointegerx(L, -1, &is_whole);
    if (type == LUA_TNIL && fallback >= 0)
        value = fallback;
    else if (type != LUA_TNUMBER || !is_whole || value < least || value > most)
        field_raise(L, arg->name,
                    "args.%s: %s is %s; expected a whole number from %" PRId64 " to %" PRId64,
                    arg->name, field ? field : "the number of elements",
                    script_tostring(L, -1, NULL), least, most);
    lua_pop(L, 1);
    return (uint64_t)value;
}

static double read_double(lua_State *L, const task_arg *arg, const char *field, double fallback)
{
    int type = lua_getfield(L, -1, field);
    double value = type == LUA_TNIL ? fallback : lua_tonumber(L, -1);
    if ((type != LUA_TNIL && type != LUA_TNUMBER) || !isfinite(value))
        field_raise(L, arg->name, "args.%s: %s is %s; expected a finite number", arg->name, field,
                    script_tostring(L, -1, NULL));
    lua_pop(L, 1);
    return value;
}

static void check_names(lua_State *L, const task_arg *arg)
{
    static const char *const names[] = {"init", "min", "max", "access", "halo", "send", NULL};
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        bool known =
            lua_isinteger(L, -2) && (lua_tointeger(L, -2) == 1 || lua_tointeger(L, -2) == 2);
        for (int i = 0; names[i] && lua_type(L, -2) == LUA_TSTRING && !known; ++i)
            known = strcmp(names[i], lua_tostring(L, -2)) == 0;
        if (!known)
            field_raise(L, arg->name,
                        "args.%s has no field [%s]: there are a type, a number of elements, init, "
                        "min, max, access, halo, send",
                        arg->name, script_tostring(L, -2, NULL));
    }
}

static void read_type(lua_State *L, task_arg *arg, task_scalar *scalar)
{
    lua_rawgeti(L, -1, 1);
    const char *type = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "";
    if (!task_type_read(type, scalar, &arg->lanes))
        field_raise(L, arg->name,
                    "args.%s: the type is %s; expected char, short, int, long, one of these with u "
                    "before it, float or double, and 2, 4, 8 or 16 behind it for a vector",
                    arg->name, script_tostring(L, -1, NULL));
    snprintf(arg->type, sizeof arg->type, "%s", type);
    lua_pop(L, 1);
}

static void read_access(lua_State *L, task_arg *arg)
{
    int type = lua_getfield(L, -1, "access");
    int access = TASK_ALL;
    while (type != LUA_TNIL && task_access_name((task_access)access) &&
           (type != LUA_TSTRING ||
            strcmp(lua_tostring(L, -1), task_access_name((task_access)access)) != 0))
        ++access;
    if (!task_access_name((task_access)access))
        field_raise(L, arg->name,
                    "args.%s: access is %s; expected all, slice, out slice, in out slice or sum",
                    arg->name, script_tostring(L, -1, NULL));
    arg->access = (task_access)access;
    lua_pop(L, 1);
}

static void read_send(lua_State *L, task_arg *arg)
{
    int type = lua_getfield(L, -1, "send");
    const char *send = type == LUA_TSTRING ? lua_tostring(L, -1) : type == LUA_TNIL ? "each" : "";
    arg->once = strcmp(send, "once") == 0;
    if (!arg->once && strcmp(send, "each") != 0)
        field_raise(L, arg->name, "args.%s: send is %s; expected each or once", arg->name,
                    script_tostring(L, -1, NULL));
    if (arg->once && arg->access > TASK_SLICE)
        field_raise(L, arg->name, "args.%s: send is once, but access is %s; expected all or slice",
                    arg->name, task_access_name(arg->access));
    lua_pop(L, 1);
}

// ---------------------------------------------------------------- what an array holds at first

// A script pays for the numbers that the host makes for it, so that no file takes long or much.
static void fill(lua_State *L, reading *r, task_arg *arg)
{
    script_spend(L, arg->count * arg->lanes / 64);
    if (!task_values_make(&arg->initial, arg->initial.scalar, arg->count * arg->lanes, r->why))
        luaL_error(L, "args.%s: %s", arg->name, r->why->text);
}

// Puts the number on top of the stack into the array.
static void put(lua_State *L, task_arg *arg, uint64_t i)
{
    task_values *v = &arg->initial;
    if (task_values_put(v, i, L, -1))
        return;
    field_raise(L, arg->name, "args.%s: init gives %s for number %" PRIu64 "; expected a%s %s",
                arg->name, script_tostring(L, -1, NULL), i,
                task_scalar_is_whole(v->scalar) ? " whole number of" : " number for", arg->type);
}

static uint64_t hash_of(const char *name)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (; *name; ++name)
        hash = (hash ^ (unsigned char)*name) * UINT64_C(1099511628211);
    return hash;
}

static void draw_whole(lua_State *L, const task_arg *arg, task_values *v, rng *source)
{
    int64_t least = (int64_t)read_whole(L, arg, "min", 0, 0, TASK_MOST, 0);
    int64_t most = (int64_t)read_whole(L, arg, "max", 0, least, least + UINT32_MAX - 1, -1);
    for (uint64_t i = 0; i < v->n; ++i)
        task_values_set_whole(v, i, least + rng_below(source, (uint32_t)(most - least) + 1));
}

static void draw(lua_State *L, const reading *r, task_arg *arg)
{
    task_values *v = &arg->initial;
    rng source = rng_stream(r->seed, hash_of(arg->name));
    script_spend(L, v->n / 8);
    if (task_scalar_is_whole(v->scalar)) {
        draw_whole(L, arg, v, &source);
        return;
    }
    double least = read_double(L, arg, "min", 0), most = read_double(L, arg, "max", 1);
    if (most < least)
        field_raise(L, arg->name, "args.%s: max is %g; expected at least min, %g", arg->name, most,
                    least);
    for (uint64_t i = 0; i < v->n; ++i)
        task_values_set(v, i, rng_between(&source, least, most));
}

// init = function(i) return ... end, on top of the stack
static void compute(lua_State *L, task_arg *arg)
{
    for (uint64_t i = 0; i < arg->initial.n; ++i) {
        lua_pushvalue(L, -1);
        lua_pushinteger(L, (lua_Integer)i);
        lua_call(L, 1, 1);
        put(L, arg, i);
        lua_pop(L, 1);
    }
}

static void count_up(lua_State *L, task_arg *arg)
{
    script_spend(L, arg->initial.n / 8);
    for (uint64_t i = 0; i < arg->initial.n; ++i) {
        lua_pushinteger(L, (lua_Integer)i);
        put(L, arg, i);
        lua_pop(L, 1);
    }
}

static void repeat(lua_State *L, task_arg *arg)
{
    script_spend(L, arg->initial.n / 8);
    for (uint64_t i = 0; i < arg->initial.n; ++i)
        put(L, arg, i);
}

static bool is_word(lua_State *L, const char *word)
{
    return lua_type(L, -1) == LUA_TSTRING && strcmp(lua_tostring(L, -1), word) == 0;
}

static void read_init(lua_State *L, reading *r, task_arg *arg)
{
    int type = lua_getfield(L, -1, "init");
    bool wants_none = arg->access == TASK_OUT || arg->access == TASK_SUM;
    if (wants_none && type != LUA_TNIL)
        field_raise(L, arg->name,
                    "args.%s: access is %s, which begins with nothing; expected no init", arg->name,
                    task_access_name(arg->access));
    if (type == LUA_TNUMBER) {
        repeat(L, arg);
    } else if (type == LUA_TFUNCTION) {
        compute(L, arg);
    } else if (is_word(L, "index")) {
        count_up(L, arg);
    } else if (is_word(L, "random")) {
        lua_pop(L, 1);
        draw(L, r, arg);
        return;
    } else if (type != LUA_TNIL) {
        field_raise(L, arg->name,
                    "args.%s: init is %s; expected random, index, a number or a function",
                    arg->name, script_tostring(L, -1, NULL));
    }
    lua_pop(L, 1);
}

// ---------------------------------------------------------------- arguments

static void divide(lua_State *L, const task *t, task_arg *arg)
{
    if (arg->access == TASK_ALL || arg->access == TASK_SUM)
        return;
    arg->per_item = arg->count / t->items;
    if (arg->count % t->items != 0)
        field_raise(L, arg->name,
                    "args.%s: %" PRIu64 " elements for %" PRIu64
                    " items; expected as many or a multiple",
                    arg->name, arg->count, t->items);
}

static void read_array(lua_State *L, reading *r, task_arg *arg)
{
    const task *t = r->task;
    check_names(L, arg);
    read_type(L, arg, &arg->initial.scalar);
    arg->is_array = true;
    arg->count = read_whole(L, arg, NULL, 2, 1, TASK_MOST, -1);
    read_access(L, arg);
    read_send(L, arg);
    divide(L, t, arg);
    arg->halo = read_whole(L, arg, "halo", 0, 0, (int64_t)t->items, 0);
    if (arg->halo > 0 && arg->access != TASK_SLICE)
        field_raise(L, arg->name, "args.%s: a halo with access %s; expected slice", arg->name,
                    task_access_name(arg->access));
    if (arg->access == TASK_SUM && task_scalar_bytes(arg->initial.scalar) < 4)
        field_raise(L, arg->name, "args.%s: a sum of %s; expected numbers of 4 or 8 bytes",
                    arg->name, arg->type);
    fill(L, r, arg);
    read_init(L, r, arg);
}

static void read_arg(lua_State *L, reading *r, task_arg *arg)
{
    int type = lua_type(L, -1);
    if (type == LUA_TTABLE) {
        read_array(L, r, arg);
    } else if (type == LUA_TNUMBER) {
        int is_whole = 0;
        arg->value = lua_tonumber(L, -1);
        arg->whole = lua_tointegerx(L, -1, &is_whole);
        arg->is_whole = is_whole;
    } else {
        field_raise(L, arg->name,
                    "args.%s is a %s; expected a number, or a table as {\"float\", n}", arg->name,
                    luaL_typename(L, -1));
    }
}

static int compare_args(const void *a, const void *b)
{
    return strcmp(((const task_arg *)a)->name, ((const task_arg *)b)->name);
}

// By name, since Lua's own order changes from run to run.
static void name_args(lua_State *L, task *t)
{
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        size_t n = lua_type(L, -2) == LUA_TSTRING ? lua_rawlen(L, -2) : 0;
        if (n == 0 || n >= GEN_NAME || strlen(lua_tostring(L, -2)) != n)
            field_raise(L, "args",
                        "args has a field [%s]; expected the names of the kernel's "
                        "arguments",
                        script_tostring(L, -2, NULL));
        if (t->n_args == GEN_MAX_ARGS)
            field_raise(L, "args", "args has more than %d arguments", GEN_MAX_ARGS);
        snprintf(t->args[t->n_args++].name, GEN_NAME, "%s", lua_tostring(L, -2));
    }
    qsort(t->args, t->n_args, sizeof *t->args, compare_args);
}

void task_args_read(lua_State *L, int root, task *t, uint64_t seed, duet_error *why)
{
    reading r = {t, seed, why};
    bool writes = false;
    if (!field_push(L, root, "args", LUA_TTABLE))
        field_raise(L, NULL, "args is missing; expected a table of the kernel's arguments");
    name_args(L, t);
    for (uint32_t i = 0; i < t->n_args; ++i) {
        lua_getfield(L, -1, t->args[i].name);
        read_arg(L, &r, &t->args[i]);
        lua_pop(L, 1);
        writes |= task_arg_is_written(&t->args[i]);
    }
    if (!writes)
        field_raise(L, "args",
                    "args: no array is written; expected one with access out slice, in "
                    "out slice or sum");
    lua_pop(L, 1);
}
