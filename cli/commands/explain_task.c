// SPDX-License-Identifier: MIT
// duet explain --task: what a task sends each device, what its kernel leaves to be chosen, and by
// what the store knows it.
#include "cli/commands/explain_task.h"

#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "runtime/task/task_launch.h"

// A task on its devices, with what is free of its kernel on each.
typedef struct explained {
    const task *task;
    const duet_device_pair *pair;
    kernel_spaces spaces[2]; // empty: the device has no work, or nothing is free
} explained;

// ---------------------------------------------------------------- arguments

// Elements that an item brings to the device that does it; 0: the device gets all of them.
static uint64_t elements_an_item(const task_arg *arg)
{
    return arg->once ? 0 : arg->per_item;
}

static void add_arguments(cJSON *o, const task *t)
{
    cJSON *list = cJSON_AddArrayToObject(o, "arguments");
    for (uint32_t i = 0; i < t->n_args; ++i) {
        const task_arg *arg = &t->args[i];
        cJSON *row = json_add_row(list);
        json_add(row, STRING("name", arg->name));
        if (arg->kind != TASK_ARG_ARRAY) {
            json_add(row, NUMBER("value", arg->value));
            continue;
        }
        json_add(row, STRING("type", arg->type), NUMBER("elements", arg->count),
                 NUMBER("an_item", (double)elements_an_item(arg)), NUMBER("halo", arg->halo),
                 STRING("access", task_access_name(arg->access)), FLAG("once", arg->once));
    }
}

// ---------------------------------------------------------------- kernels

static const char *const sides[] = {"A", "B"};

static void add_kernel(cJSON *list, const explained *e, int side)
{
    const kernel_space *s = e->spaces[side].of;
    cJSON *row = json_add_row(list);
    json_add(row, STRING("device", sides[side]),
             STRING("selector", duet_device_pair_get_info(e->pair, side)->selector),
             NUMBER("configs", s ? s->n_configs : 1));
    cJSON *params = cJSON_AddArrayToObject(row, "parameters");
    for (uint32_t i = 0; s && i < s->n_params; ++i) {
        cJSON *param = json_add_row(params);
        json_add(param, STRING("name", s->params[i].name));
        cJSON *values = cJSON_AddArrayToObject(param, "values");
        for (uint32_t k = 0; k < s->params[i].n_values; ++k)
            cJSON_AddItemToArray(values, cJSON_CreateNumber((double)s->params[i].values[k]));
        json_add(param, NUMBER("default", (double)s->params[i].values[s->configs[s->now][i]]));
    }
}

// ---------------------------------------------------------------- the whole

static bool has_work(const explained *e, int side)
{
    return side == 1 || !duet_device_pair_is_one(e->pair);
}

static cJSON *describe(const explained *e)
{
    const task *t = e->task;
    char words[TASK_WORDS];
    task_write_words(t, words);
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("type", "duet explain"), STRING("task", t->name),
             STRING("kernel", t->kernel), NUMBER("items", t->items), STRING("key", words),
             NUMBER("n", t->size), NUMBER("tolerance", t->tolerance),
             STRING("reference", t->reference));
    add_arguments(o, t);
    cJSON *kernels = cJSON_AddArrayToObject(o, "kernels");
    for (int side = 0; side < 2; ++side)
        if (has_work(e, side))
            add_kernel(kernels, e, side);
    return o;
}

static bool read_spaces(explained *e, task_launcher *l, duet_error *err)
{
    static const duet_plan usual = {.variant_a = "auto", .variant_b = "auto"};
    bool ok = true;
    for (int side = 0; ok && side < 2; ++side)
        ok = task_kernel_space(l, &usual, side, &e->spaces[side], err);
    return ok;
}

static bool explain(explained *e, task *t, duet_device_pair *pair, bool json, duet_error *err)
{
    task_launcher *l = task_launcher_open_unchecked(t, pair, err);
    bool ok = l && read_spaces(e, l, err);
    ok = ok && rendering_tell(describe(e), json, "cli/report/explain_task.lua", err);
    task_launcher_close(l);
    for (int side = 0; side < 2; ++side)
        kernel_spaces_free(&e->spaces[side]);
    return ok;
}

bool explain_task(const char *path, const scene_options *scene, const char *pair_words, bool json,
                  duet_error *err)
{
    task *t = inputs_load_task(path, scene, err);
    duet_device_pair *pair = t ? inputs_open_pair(pair_words, err) : NULL;
    explained e = {.task = t, .pair = pair};
    bool ok = pair && explain(&e, t, pair, json, err);
    duet_device_pair_destroy(pair);
    task_destroy(t);
    return ok;
}
