// SPDX-License-Identifier: MIT
#include "runtime/task/task_args.h"

#include "base/error.h"
#include "base/rng.h"
#include "gen/field.h"
#include "gen/script.h"
#include "runtime/task/task_reference.h"

#include <float.h>
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
    char name[GEN_NAME + 8]; // of the argument that is read, "args.x"
    field_table table;       // the same
} reading;

// ---------------------------------------------------------------- fields of an argument

static void read_type(lua_State *L, const field *f, void *at)
{
    (void)f;
    task_arg *arg = at;
    const char *type = field_text(L, -1);
    if (!type || !task_type_read(type, &arg->initial.scalar, &arg->lanes))
        field_raise(L, arg->name,
                    "args.%s: the type is %s; expected char, short, int, long, one of these with u "
                    "before it, float or double, and 2, 4, 8 or 16 behind it for a vector",
                    arg->name, field_push_shown(L, -1));
    snprintf(arg->type, sizeof arg->type, "%s", type);
}

static const char *access_name(int access)
{
    return task_access_name((task_access)access);
}

static void read_send(lua_State *L, const field *f, void *at)
{
    task_arg *arg = at;
    const char *send = field_text(L, -1);
    arg->once = send && strcmp(send, "once") == 0;
    if (!arg->once && (!send || strcmp(send, "each") != 0))
        field_refuse(L, f, "each or once");
}

// In the order in which they are written: the type, the number of elements, the rest.
static const field array_fields[] = {
    {.name = "[1]", .type = &(const field_type){.read = read_type}},
    {FIELD_ROW("[2]", field_count, task_arg, count), .least = 1, .most = (double)TASK_MOST,
     .expected = "a number of elements, from 1 to 2^40"},
    FIELD_ENUM(task_arg, access, access_name),
    {.name = "send", .type = &(const field_type){.read = read_send}},
    FIELDS(task_arg, halo),
    {.name = "init", .type = &field_unread},
    {.name = "min", .type = &field_unread},
    {.name = "max", .type = &field_unread},
    {0},
};

enum { TYPE_AND_COUNT = 3 };

// Reads one of the range's ends from the argument's table, which is on top of the stack.
static bool read_end(lua_State *L, const reading *r, const char *name, const field_type *type,
                     void *to)
{
    const field end = {.name = name,
                       .type = type,
                       .size = sizeof(double),
                       .least = -DBL_MAX,
                       .most = DBL_MAX,
                       .table = &r->table};
    return field_read_one(L, -1, &end, to);
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
                arg->name, field_push_shown(L, -1), i,
                task_scalar_is_whole(v->scalar) ? " whole number of" : " number for", arg->type);
}

static uint64_t hash_of(const char *name)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (; *name; ++name)
        hash = (hash ^ (unsigned char)*name) * UINT64_C(1099511628211);
    return hash;
}

static void draw_whole(lua_State *L, const reading *r, const task_arg *arg, task_values *v,
                       rng *source)
{
    int64_t least = 0, most = -1;
    read_end(L, r, "min", &field_int, &least);
    bool given = read_end(L, r, "max", &field_int, &most);
    if (!given || least < 0 || most < least || most - least >= UINT32_MAX)
        field_raise(L, arg->name,
                    "args.%s: min is %" PRId64 ", max is %s%.0" PRId64
                    "; expected whole numbers from 0 on, max at least min",
                    arg->name, least, given ? "" : "nil", given ? most : 0);
    for (uint64_t i = 0; i < v->n; ++i)
        task_values_set_whole(v, i, least + rng_below(source, (uint32_t)(most - least) + 1));
}

static void draw(lua_State *L, const reading *r, task_arg *arg)
{
    task_values *v = &arg->initial;
    rng source = rng_stream(r->seed, hash_of(arg->name));
    double least = 0, most = 1;
    script_spend(L, v->n / 8);
    if (task_scalar_is_whole(v->scalar)) {
        draw_whole(L, r, arg, v, &source);
        return;
    }
    read_end(L, r, "min", &field_double, &least);
    read_end(L, r, "max", &field_double, &most);
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
    const char *chars = field_text(L, -1);
    return chars && strcmp(chars, word) == 0;
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
                    arg->name, field_push_shown(L, -1));
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

static void check_array(lua_State *L, const task *t, const task_arg *arg)
{
    if (arg->once && arg->access > TASK_SLICE)
        field_raise(L, arg->name, "args.%s: send is once, but access is %s; expected all or slice",
                    arg->name, task_access_name(arg->access));
    if (arg->halo > 0 && arg->access != TASK_SLICE)
        field_raise(L, arg->name, "args.%s: a halo with access %s; expected slice", arg->name,
                    task_access_name(arg->access));
    if (arg->halo > t->items)
        field_raise(L, arg->name,
                    "args.%s: halo is %" PRIu64 "; expected at most %" PRIu64 " items", arg->name,
                    arg->halo, t->items);
    if (arg->access == TASK_SUM && task_scalar_bytes(arg->initial.scalar) < 4)
        field_raise(L, arg->name, "args.%s: a sum of %s; expected numbers of 4 or 8 bytes",
                    arg->name, arg->type);
}

static void read_array(lua_State *L, reading *r, task_arg *arg)
{
    uint64_t given = field_read_row(L, -1, r->table, array_fields, arg);
    if ((given & TYPE_AND_COUNT) != TYPE_AND_COUNT)
        field_raise(L, arg->name, "args.%s: expected a type and a number of elements", arg->name);
    arg->kind = TASK_ARG_ARRAY;
    divide(L, r->task, arg);
    check_array(L, r->task, arg);
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
        arg->kind = is_whole ? TASK_ARG_WHOLE : TASK_ARG_REAL;
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
        const char *name = field_text(L, -2);
        if (!name || !*name || strlen(name) >= GEN_NAME)
            field_raise(L, "args",
                        "args has a field [%s]; expected the names of the kernel's "
                        "arguments",
                        field_push_shown(L, -2));
        if (t->n_args == GEN_MAX_ARGS)
            field_raise(L, "args", "args has more than %d arguments", GEN_MAX_ARGS);
        snprintf(t->args[t->n_args++].name, GEN_NAME, "%s", name);
    }
    qsort(t->args, t->n_args, sizeof *t->args, compare_args);
}

void task_args_read(lua_State *L, int root, task *t, uint64_t seed, duet_error *why)
{
    reading r = {.task = t, .seed = seed, .why = why};
    bool writes = false;
    if (lua_getfield(L, root, "args") != LUA_TTABLE)
        field_raise(L, NULL, "args is missing; expected a table of the kernel's arguments");
    name_args(L, t);
    for (uint32_t i = 0; i < t->n_args; ++i) {
        snprintf(r.name, sizeof r.name, "args.%s", t->args[i].name);
        r.table = (field_table){r.name, -1, NULL};
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
