// SPDX-License-Identifier: MIT
// A task as a def in C: a table as a task file would return it, whose arrays the def holds.
#define _POSIX_C_SOURCE 200809L // strdup
#include "runtime/task/task_def.h"

#include "base/error.h"
#include "base/text.h"
#include "gen/field_line.h"
#include "gen/sandbox.h"
#include "runtime/task/task_read.h"
#include "runtime/task/task_reference.h"

#include <lauxlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- the table

// NULL is left out, and so is 0.
static void set_string(lua_State *L, const char *field, const char *value)
{
    lua_pushstring(L, value);
    lua_setfield(L, -2, field);
}

// The greatest number that Lua has stands for those above, which are refused, too.
static void push_count(lua_State *L, uint64_t value)
{
    lua_pushinteger(L, (lua_Integer)(value < INT64_MAX ? value : INT64_MAX));
}

static void set_count(lua_State *L, const char *field, uint64_t value)
{
    if (value == 0)
        return;
    push_count(L, value);
    lua_setfield(L, -2, field);
}

static void push_array(lua_State *L, const duet_task_arg_def *arg)
{
    lua_newtable(L);
    lua_pushstring(L, arg->type);
    lua_rawseti(L, -2, 1);
    push_count(L, arg->elements);
    lua_rawseti(L, -2, 2);
    set_string(L, "access", arg->access);
    set_count(L, "halo", arg->halo);
    set_string(L, "send", arg->send);
}

static void set_args(lua_State *L, const duet_task_def *def)
{
    lua_newtable(L);
    for (uint32_t i = 0; i < def->n_args; ++i) {
        const duet_task_arg_def *arg = &def->args[i];
        if (lua_getfield(L, -1, arg->name) != LUA_TNIL)
            field_raise(L, NULL, "args.%s is there twice", arg->name);
        lua_pop(L, 1);
        if (arg->type)
            push_array(L, arg);
        else
            lua_pushnumber(L, arg->number);
        lua_setfield(L, -2, arg->name);
    }
    lua_setfield(L, -2, "args");
}

// n is a number, and other words are as they are written.
static void set_key(lua_State *L, const duet_task_def *def)
{
    lua_newtable(L);
    for (uint32_t i = 0; i < def->n_key; ++i) {
        const duet_setting *word = &def->key[i];
        if (strcmp(word->name, "n") != 0 || !lua_stringtonumber(L, word->value))
            lua_pushstring(L, word->value);
        lua_setfield(L, -2, word->name);
    }
    lua_setfield(L, -2, "key");
}

static void set_work(lua_State *L, const duet_task_def *def)
{
    if (def->high == 0) {
        set_count(L, "work", def->work);
        return;
    }
    lua_newtable(L);
    push_count(L, def->work);
    lua_rawseti(L, -2, 1);
    push_count(L, def->high);
    lua_rawseti(L, -2, 2);
    lua_setfield(L, -2, "work");
}

// def -> table
static int push_task(lua_State *L)
{
    const duet_task_def *def = lua_touserdata(L, 1);
    lua_newtable(L);
    set_string(L, "kernel", def->kernel);
    set_string(L, "entry", def->entry);
    set_args(L, def);
    push_count(L, def->items);
    lua_setfield(L, -2, "items");
    set_work(L, def);
    set_string(L, "reference", def->reference);
    lua_pushnumber(L, def->tolerance);
    lua_setfield(L, -2, "tolerance");
    set_key(L, def);
    return 1;
}

static bool read(task_reading *r, const duet_task_def *def, duet_error *err)
{
    script_limits limits = script_default_limits();
    limits.failure = DUET_STATUS_BAD_ARGUMENT;
    limits.instructions = UINT64_MAX; // the caller's own numbers, and no script
    limits.seconds = 1e9;             // for arrays of any size
    script *s = sandbox_open(&limits, err);
    if (!s)
        return false;
    lua_State *L = script_lua(s);
    bool ok = script_run(s, r->task->path, "", 0, 0, err); // from here on messages begin with it
    lua_pushcfunction(L, push_task);
    lua_pushlightuserdata(L, (void *)def);
    ok = ok && script_call(s, 1, 1, err);
    lua_pushcfunction(L, task_read_table);
    lua_insert(L, -2);
    lua_pushlightuserdata(L, r);
    ok = ok && script_call(s, 2, 0, err);
    script_close(s);
    return ok;
}

// ---------------------------------------------------------------- its arrays

static bool refuse(const task *t, const char *name, const char *what, duet_error *err)
{
    return bad_argument(err, "%s: args.%s %s", t->path, name, what);
}

static bool take_initial(task *t, task_arg *arg, const duet_task_arg_def *def, duet_error *err)
{
    if (!def->initial)
        return true;
    if (arg->kind != TASK_ARG_ARRAY || arg->access == TASK_OUT || arg->access == TASK_SUM)
        return refuse(t, arg->name, "has initial values; expected them of an array that is read",
                      err);
    memcpy(arg->initial.bytes, def->initial, arg->initial.size);
    return true;
}

static bool take_expected(task *t, task_arg *arg, const duet_task_arg_def *def, duet_error *err)
{
    if (!def->expected)
        return !arg->expected.bytes ||
               refuse(t, arg->name, "has no expected values, but others have; expected all or none",
                      err);
    if (!task_arg_is_written(arg))
        return refuse(t, arg->name,
                      "has expected values; expected them of an array that is "
                      "written",
                      err);
    memcpy(arg->expected.bytes, def->expected, arg->initial.size);
    return true;
}

static bool expects(const duet_task_def *def)
{
    bool any = false;
    for (uint32_t i = 0; i < def->n_args; ++i)
        any |= def->args[i].expected != NULL;
    return any;
}

static bool take_arrays(task *t, const duet_task_def *def, task_use use, duet_error *err)
{
    bool known = use == TASK_CHECKED && expects(def);
    bool ok = true;
    for (uint32_t i = 0; ok && i < def->n_args; ++i)
        ok = take_initial(t, &t->args[task_find_arg(t, def->args[i].name)], &def->args[i], err);
    if (known && def->reference)
        return bad_argument(
            err, "%s: there are a reference and expected values; expected one of them", t->path);
    ok = ok && (!known || task_expect_initial(t, err));
    for (uint32_t i = 0; ok && known && i < def->n_args; ++i)
        ok = take_expected(t, &t->args[task_find_arg(t, def->args[i].name)], &def->args[i], err);
    return ok;
}

// ---------------------------------------------------------------- owner

static bool check_pointers(const duet_task_def *def, const char *call, duet_error *err)
{
    bool ok = error_given(def->kernel, call, "the def's path, or else its kernel,", err) &&
              (def->n_args == 0 || error_given(def->args, call, "args", err)) &&
              (def->n_kernels == 0 || error_given(def->kernels, call, "kernels", err)) &&
              (def->n_key == 0 || error_given(def->key, call, "key", err));
    for (uint32_t i = 0; ok && i < def->n_kernels; ++i)
        ok = error_given(def->kernels[i].name, call, "the name of a kernel", err) &&
             error_given(def->kernels[i].card, call, "the card of a kernel", err) &&
             error_given(def->kernels[i].text, call, "the text of a kernel", err);
    for (uint32_t i = 0; ok && i < def->n_args; ++i)
        ok = error_given(def->args[i].name, call, "the name of an argument", err);
    for (uint32_t i = 0; ok && i < def->n_key; ++i)
        ok = error_given(def->key[i].name, call, "the name of a word of the key", err) &&
             error_given(def->key[i].value, call, "the value of a word of the key", err);
    return ok;
}

static char *copy(const char *chars, bool *ok)
{
    char *made = strdup(chars);
    *ok = *ok && made;
    return made;
}

static bool copy_kernels(task *t, const duet_task_def *def)
{
    bool ok = true;
    t->kernels = calloc(def->n_kernels + 1, sizeof *t->kernels);
    t->n_kernels = t->kernels ? def->n_kernels : 0;
    for (uint32_t i = 0; i < t->n_kernels; ++i) {
        const duet_kernel_text *k = &def->kernels[i];
        t->kernels[i] = (task_kernel){copy(k->name, &ok), copy(k->card, &ok), copy(k->text, &ok)};
    }
    return ok && t->kernels;
}

// Messages begin with "the task of kernel saxpy".
static bool take_names(task *t, const duet_task_def *def, duet_error *err)
{
    text path = {0};
    bool ok = copy_kernels(t, def);
    snprintf(t->name, sizeof t->name, "%s", def->kernel);
    text_add(&path, "the task of kernel %.48s", def->kernel);
    t->path = path.chars;
    t->folder = def->folder ? copy(def->folder, &ok) : NULL;
    return (ok && text_ok(&path, err)) || no_memory(err, "the task of kernel %.48s", def->kernel);
}

task *task_make(const duet_task_def *def, task_use use, const char *call, duet_error *err)
{
    if (!check_pointers(def, call, err))
        return NULL;
    task *t = calloc(1, sizeof *t);
    if (!t)
        return null_no_memory(err, "%s", call);
    task_reading r = {.task = t, .use = use};
    if (take_names(t, def, err) && read(&r, def, err) && take_arrays(t, def, use, err))
        return t;
    task_destroy(t);
    return NULL;
}
