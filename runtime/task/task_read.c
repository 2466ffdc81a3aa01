// SPDX-License-Identifier: MIT
// A task as a Lua file that returns a table, read field by field.
#include "runtime/task/task.h"

#include "base/error.h"
#include "base/text_file.h"
#include "gen/field.h"
#include "gen/parameters.h"
#include "gen/sandbox.h"
#include "runtime/task/task_args.h"
#include "runtime/task/task_read.h"
#include "runtime/task/task_reference.h"

#include <float.h>
#include <inttypes.h>
#include <lauxlib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOT = 1, READING = 2 };

// ---------------------------------------------------------------- parameters

// parameters{name = default, ...} -> the same with what was set from outside
static int word_parameters(lua_State *L)
{
    task_reading *r = lua_touserdata(L, lua_upvalueindex(1));
    parameters_declare(L, &r->declared);
    for (uint32_t i = 0; i < r->n_settings; ++i)
        parameters_set(L, "the task", r->settings[i].name, r->settings[i].value);
    r->seed = parameters_seed(L);
    return 1;
}

static int open_words(lua_State *L)
{
    lua_pushcclosure(L, word_parameters, 1);
    lua_setglobal(L, "parameters");
    return 0;
}

// ---------------------------------------------------------------- the task's own fields

#define A_COUNT "a whole number from 1 to 2^40"
#define COUNT_ROW(name_, member)                                                        \
    FIELD_ROW(name_, field_count, task, member), .least = 1, .most = (double)TASK_MOST, \
                                                 .expected = A_COUNT

static void read_tolerance(lua_State *L, const field *f, void *at)
{
    const char *word = field_text(L, -1);
    if (!word || strcmp(word, "exact") != 0)
        field_double.read(L, f, at);
}

// Adds "bins=64"; the table is on top of the stack.
static void add_word(lua_State *L, task *t, const char *name)
{
    static const char allowed[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-";
    lua_getfield(L, -1, name);
    size_t length = 0, used = strlen(t->key), space = sizeof t->key - used;
    const char *value = script_tostring(L, -1, &length);
    if (!*name || name[strspn(name, allowed)] || !*value || strspn(value, allowed) < length)
        field_raise(L, "key",
                    "key: '%.100s' is '%s'; expected names and values of letters and digits", name,
                    field_push_shown(L, -1));
    if (snprintf(t->key + used, space, "%s%s=%s", used ? " " : "", name, value) >= (int)space)
        field_raise(L, "key", "key is longer than %d letters", TASK_KEY - 1);
    lua_pop(L, 2);
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

// Adds all words but n, by name, since Lua's own order changes from run to run.
static void add_words(lua_State *L, task *t)
{
    enum { MOST_WORDS = 16 };
    const char *names[MOST_WORDS];
    uint32_t n = 0;
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        const char *name = field_text(L, -2); // the table keeps it alive
        if (!name || n == MOST_WORDS)
            field_raise(L, "key", "key: expected at most %d words, as bins = 64", MOST_WORDS);
        if (strcmp(name, "n") != 0)
            names[n++] = name;
    }
    qsort(names, n, sizeof *names, compare_names);
    for (uint32_t i = 0; i < n; ++i)
        add_word(L, t, names[i]);
}

// Its n is the size, by which tasks of one kind are neighbours.
static void read_key(lua_State *L, task *t)
{
    static const field_table key = {"key", -1, NULL};
    static const field n = {COUNT_ROW("n", size), .table = &key};
    t->size = t->items;
    if (lua_getfield(L, ROOT, "key") == LUA_TTABLE) {
        field_read_one(L, -1, &n, t);
        add_words(L, t);
    } else if (!lua_isnil(L, -1)) {
        field_raise(L, "key", "key is a %s; expected words, as bins = 64", luaL_typename(L, -1));
    }
    lua_pop(L, 1);
}

// A number, or { wide, high }.
static void read_work(lua_State *L, const field *f, void *at)
{
    static const field_table table = {"work", -1, NULL};
    static const field wide = {COUNT_ROW("[1]", wide), .table = &table};
    static const field high = {COUNT_ROW("[2]", work), .table = &table};
    task *t = at;
    if (!lua_istable(L, -1)) {
        field_count.read(L, f, &t->work);
        t->wide = t->work;
        return;
    }
    if (lua_rawlen(L, -1) != 2)
        field_refuse(L, f, "a number, or { wide, high }");
    field_read_one(L, -1, &wide, t);
    field_read_one(L, -1, &high, t);
    t->work = t->work > (uint64_t)TASK_MOST / t->wide ? UINT64_MAX : t->wide * t->work;
}

// Left out, it has the kernel's name; given, it is no longer empty.
static void read_entry(lua_State *L, const field *f, void *at)
{
    field_chars.read(L, f, at);
    if (!*(char *)at)
        field_refuse(L, f, "the name of a function of the kernel");
}

static const field task_fields[] = {
    FIELDS(task, kernel),
    FIELD_AT("entry", (const field_type){.read = read_entry}, task, entry),
    {COUNT_ROW("items", items)},
    {.name = "work",
     .type = &(const field_type){.read = read_work},
     .size = sizeof(uint64_t),
     .least = 1,
     .most = (double)TASK_MOST,
     .expected = "a number, 1 to 1099511627776, or { wide, high }"},
    {.name = "tolerance",
     .type = &(const field_type){.read = read_tolerance},
     .offset = offsetof(task, tolerance),
     .size = sizeof(double),
     .most = DBL_MAX,
     .expected = "a number from 0 or exact"},
    {.name = "key", .type = &field_unread},
    {.name = "args", .type = &field_unread},
    {.name = "reference", .type = &field_unread},
    {0},
};

static void check_fields(lua_State *L, task *t)
{
    t->kernel_line = field_line(L, "kernel");
    t->reference_line = field_line(L, "reference");
    if (!*t->kernel)
        field_raise(L, NULL, "kernel is missing or empty; expected a kernel's name");
    if (!*t->entry)
        memcpy(t->entry, t->kernel, sizeof t->entry);
    if (t->items == 0)
        field_raise(L, NULL, "items is missing; expected how many there are");
    if (t->work > (uint64_t)TASK_MOST / t->items)
        field_raise(L, "work",
                    "work is %" PRIu64 " for each of %" PRIu64 " items; expected at most "
                    "%" PRId64 " for all",
                    t->work, t->items, TASK_MOST);
}

int task_read_table(lua_State *L)
{
    task_reading *r = lua_touserdata(L, READING);
    task *t = r->task;
    if (!lua_istable(L, ROOT))
        return field_raise(L, NULL, "a task file returns a table, not %s", luaL_typename(L, ROOT));
    if (r->n_settings > 0 && !r->declared) {
        script_set_failure(L, DUET_STATUS_BAD_ARGUMENT);
        return field_raise(L, NULL, "no parameter '%s'; the task declares none",
                           r->settings[0].name);
    }
    t->work = t->wide = 1;
    field_read(L, ROOT, "a task", task_fields, t);
    check_fields(L, t);
    read_key(L, t);
    task_args_read(L, ROOT, t, r->seed, &r->why);
    lua_settop(L, READING);
    if (r->use == TASK_CHECKED)
        task_reference_read(L, ROOT, t, &r->why);
    return 0;
}

// ---------------------------------------------------------------- the file

// Enough for ten million numbers that Lua computes; an endless loop ends within seconds.
static const script_limits limits = {
    .memory_bytes = (size_t)256 << 20, .instructions = 1000000000, .seconds = 30};

// "saxpy" of "kernels/saxpy.task.lua", and its folder
static bool take_path(task *t, const char *path, duet_error *err)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    snprintf(t->name, sizeof t->name, "%.*s", (int)strcspn(name, "."), name);
    size_t folder = slash > path ? (size_t)(slash - path) : 1;
    t->path = malloc(strlen(path) + 1);
    t->folder = malloc(folder + 2);
    if (!t->path || !t->folder)
        return no_memory(err, "%s", path);
    snprintf(t->path, strlen(path) + 1, "%s", path);
    snprintf(t->folder, folder + 2, "%.*s", (int)folder, slash ? path : ".");
    return true;
}

static bool read_script(task_reading *r, const char *path, const text *chars, duet_error *err)
{
    script *s = sandbox_open(&limits, err);
    if (!s)
        return false;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, open_words);
    lua_pushlightuserdata(L, r);
    bool ok = script_call(s, 1, 0, err);
    lua_pushcfunction(L, task_read_table);
    ok = ok && script_run(s, path, text_chars(chars), chars->length, 1, err);
    lua_pushlightuserdata(L, r);
    ok = ok && script_call(s, 2, 0, err);
    script_close(s);
    return ok;
}

static task *load(task_reading *r, const char *path, duet_error *err)
{
    task *t = r->task = calloc(1, sizeof *t);
    text chars = {0};
    if (!t)
        return null_no_memory(err, "%s", path);
    bool ok = take_path(t, path, err) && text_read_lines(&chars, path, err);
    if (ok && text_ends_with(path, ".cl"))
        ok = bad_input(err, "%s: the text of a kernel; expected a task file, which names it", path);
    ok = ok && read_script(r, path, &chars, err);
    text_free(&chars);
    if (ok)
        return t;
    task_destroy(t);
    return NULL;
}

task *task_load(const char *path, const duet_setting *settings, uint32_t n_settings,
                duet_error *err)
{
    task_reading r = {.settings = settings, .n_settings = n_settings, .use = TASK_CHECKED};
    return load(&r, path, err);
}

task *task_load_unchecked(const char *path, const duet_setting *settings, uint32_t n_settings,
                          duet_error *err)
{
    task_reading r = {.settings = settings, .n_settings = n_settings, .use = TASK_UNCHECKED};
    return load(&r, path, err);
}
