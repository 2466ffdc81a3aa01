// SPDX-License-Identifier: MIT
// duet.task_file: a kernel of the user's, to be tuned; device_pair:task: the same, to be run.
#include "lua/nouns.h"
#include "lua/policy.h"

#include "runtime/task/task_reference.h"

#include <string.h>

static void check_policy(lua_State *L)
{
    policy_check_trusted(L, "running a kernel from a file");
}

// ---------------------------------------------------------------- task files

CLASS_DESTROY(task_file)
static const lua_class file_class = {
    .name = "duet.task_file", .destroy = destroy_task_file, .noun = "task file"};

// duet.task_file(path, settings)
static int file_load(lua_State *L)
{
    duet_error err = {0};
    uint32_t n = 0;
    const char *path = text_check(L, 1);
    const duet_setting *settings = scene_read_settings(L, 2, &n);
    check_policy(L);
    lua_handle *file = class_push(L, &file_class, sizeof *file);
    file->object = duet_task_file_load(path, settings, n, &err);
    return file->object ? 1 : class_push_failure(L, &err);
}

duet_task_file *task_file_test(lua_State *L, int index)
{
    return luaL_testudata(L, index, file_class.name) ? class_object(L, index, &file_class) : NULL;
}

// ---------------------------------------------------------------- tasks

CLASS_DESTROY(task)
static const lua_class task_class = {.name = "duet.task", .destroy = destroy_task, .noun = "task"};

duet_task *task_check_lua(lua_State *L, int index)
{
    return class_object(L, index, &task_class);
}

// device_pair:task(path, settings)
static int device_pair_task(lua_State *L)
{
    duet_error err = {0};
    duet_task_def def = duet_default_task_def();
    def.pair = device_pair_check(L);
    def.path = text_check(L, 2);
    def.settings = scene_read_settings(L, 3, &def.n_settings);
    check_policy(L);
    lua_handle *t = class_push_of(L, &task_class, sizeof *t, 1);
    t->object = duet_task_create(&def, &err);
    return t->object ? 1 : class_push_failure(L, &err);
}

// task:args() -> a table each, by name
static int task_args(lua_State *L)
{
    const duet_task *t = task_check_lua(L, 1);
    lua_newtable(L);
    for (uint32_t i = 0; duet_task_get_arg(t, i); ++i) {
        field_push_table(L, FIELD_LIST(duet_task_arg, name, type, access, elements, bytes),
                         duet_task_get_arg(t, i));
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static int task_items(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)duet_task_get_items(task_check_lua(L, 1)));
    return 1;
}

// ---------------------------------------------------------------- arguments

static const duet_task_arg *find_arg(lua_State *L, const duet_task *t, const char *name)
{
    const duet_task_arg *arg = NULL;
    for (uint32_t i = 0; (arg = duet_task_get_arg(t, i)); ++i)
        if (strcmp(arg->name, name) == 0)
            return arg;
    luaL_argerror(
        L, 2, lua_pushfstring(L, "the task has no argument '%s'; task:args() lists them", name));
    return NULL;
}

// The components of the argument's elements at these bytes.
static task_values values_of(const duet_task_arg *arg, uint64_t elements, void *bytes)
{
    task_values v = {.bytes = bytes, .size = (size_t)elements * arg->bytes};
    uint32_t lanes = 1;
    task_type_read(arg->type, &v.scalar, &lanes);
    v.n = elements * lanes;
    return v;
}

// A list of numbers at 3, a component each, becomes elements that take its place.
static const void *read_list(lua_State *L, const duet_task_arg *arg, uint64_t *elements)
{
    lua_Unsigned n = lua_rawlen(L, 3);
    uint64_t lanes = values_of(arg, 1, NULL).n;
    if (n % lanes != 0)
        luaL_argerror(L, 3,
                      lua_pushfstring(L,
                                      "%I numbers for elements of %s; expected a multiple "
                                      "of %I",
                                      (LUAI_UACINT)n, arg->type, (LUAI_UACINT)lanes));
    *elements = n / lanes;
    void *bytes = lua_newuserdatauv(L, (size_t)(*elements * arg->bytes) + 1, 0);
    task_values v = values_of(arg, *elements, bytes);
    for (uint64_t i = 0; i < v.n; ++i) {
        lua_rawgeti(L, 3, (lua_Integer)i + 1);
        if (!task_values_put(&v, i, L, -1))
            luaL_argerror(L, 3,
                          lua_pushfstring(L, "number %I is %s; expected one that %s holds",
                                          (LUAI_UACINT)i + 1, field_push_shown(L, -1), arg->type));
        lua_pop(L, 1);
    }
    return bytes;
}

// The elements at 3: a list of numbers, or their bytes as a string.
static const void *read_elements(lua_State *L, const duet_task_arg *arg, uint64_t *elements)
{
    if (lua_type(L, 3) != LUA_TSTRING) {
        luaL_checktype(L, 3, LUA_TTABLE);
        return read_list(L, arg, elements);
    }
    size_t size = 0;
    const char *bytes = lua_tolstring(L, 3, &size);
    if (size % arg->bytes != 0)
        luaL_argerror(L, 3,
                      lua_pushfstring(L, "%I bytes for elements of %I", (LUAI_UACINT)size,
                                      (LUAI_UACINT)arg->bytes));
    *elements = size / arg->bytes;
    return bytes;
}

// task:set(name, number, list or string) -> task
static int task_set(lua_State *L)
{
    duet_error err = {0};
    duet_task *t = task_check_lua(L, 1);
    const char *name = text_check(L, 2);
    const duet_task_arg *arg = find_arg(L, t, name);
    uint64_t n = 0;
    bool ok;
    lua_settop(L, 3);
    if (arg->elements > 0) {
        const void *elements = read_elements(L, arg, &n);
        ok = duet_task_set_array(t, name, elements, n, &err);
    } else if (lua_isinteger(L, 3)) {
        ok = duet_task_set_integer(t, name, lua_tointeger(L, 3), &err);
    } else {
        ok = duet_task_set_number(t, name, luaL_checknumber(L, 3), &err);
    }
    lua_settop(L, 1);
    return ok ? 1 : class_push_failure(L, &err);
}

static void push_list(lua_State *L, const task_values *v)
{
    lua_createtable(L, v->n < INT32_MAX ? (int)v->n : INT32_MAX, 0);
    for (uint64_t i = 0; i < v->n; ++i) {
        if (task_scalar_is_whole(v->scalar))
            lua_pushinteger(L, task_values_get_whole(v, i));
        else
            lua_pushnumber(L, task_values_get(v, i));
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

// task:get(name) -> a list of numbers; task:get(name, "bytes") -> a string
static int task_get(lua_State *L)
{
    static const char *const forms[] = {"numbers", "bytes", NULL};
    duet_error err = {0};
    duet_task *t = task_check_lua(L, 1);
    const char *name = text_check(L, 2);
    int form = luaL_checkoption(L, 3, "numbers", forms);
    const duet_task_arg *arg = find_arg(L, t, name);
    const void *elements = duet_task_get_array(t, name, NULL, &err);
    if (!elements)
        return class_push_failure(L, &err);
    task_values v = values_of(arg, arg->elements, (void *)elements);
    if (form == 0)
        push_list(L, &v);
    else
        lua_pushlstring(L, v.bytes, v.size);
    return 1;
}

// ---------------------------------------------------------------- runs

static int task_plan(lua_State *L)
{
    return plan_push(L, duet_task_get_plan(task_check_lua(L, 1)));
}

// task:set_plan(plan) -> task
static int task_set_plan(lua_State *L)
{
    duet_error err = {0};
    duet_task *t = task_check_lua(L, 1);
    duet_plan plan = *duet_task_get_plan(t);
    plan_read(L, &plan);
    if (!duet_task_set_plan(t, &plan, &err))
        return class_push_failure(L, &err);
    lua_settop(L, 1);
    return 1;
}

int task_result_push(lua_State *L, const duet_task_result *result)
{
    field_push_table(L, FIELD_LIST(duet_task_result, total_ms, device_ms), result);
    stages_push(L, result->stages, result->n_stages);
    lua_setfield(L, -2, "stages");
    return 1;
}

// task:run() -> { total_ms, device_ms, stages }
static int task_run(lua_State *L)
{
    duet_error err = {0};
    duet_task_result result;
    class_check_limits(L);
    if (!duet_task_run(task_check_lua(L, 1), &result, &err))
        return class_push_failure(L, &err);
    return task_result_push(L, &result);
}

const lua_noun task_noun = {
    {&file_class, &task_class},
    (const lua_method[]){{"duet.task_file", file_load, 0},
                         METHODS(device_pair, task),
                         METHODS(task, args, items, set, get, plan, set_plan, run),
                         {0}}};
