// SPDX-License-Identifier: MIT
#include "cli/commands/source.h"

#include "cli/report/json.h"
#include "cli/report/rendering.h"

static void add_param(cJSON *list, const gen_param *p)
{
    cJSON *o = json_add_row(list);
    json_add(o, STRING("name", p->name), STRING("about", p->about), NUMBER("default", p->fallback));
    if (p->is_range) {
        json_add(o, NUMBER("min", p->least), NUMBER("max", p->most));
    }
    cJSON *values = cJSON_AddArrayToObject(o, "values");
    for (uint32_t i = 0; i < p->n_values; ++i)
        cJSON_AddItemToArray(values, cJSON_CreateNumber((double)p->values[i]));
}

static bool add_kernel(cJSON *list, gen *g, const char *name, const gen_limits *limits,
                       duet_error *err)
{
    const char *about;
    const gen_param *params;
    uint32_t n_params;
    uint64_t configs;
    if (!gen_about(g, name, &about, err) || !gen_count(g, name, limits, &configs, err) ||
        !gen_params(g, name, limits, &params, &n_params, err))
        return false;
    cJSON *o = json_add_row(list);
    json_add(o, STRING("name", name), STRING("about", about), NUMBER("configs", configs));
    cJSON *array = cJSON_AddArrayToObject(o, "params");
    for (uint32_t i = 0; i < n_params; ++i)
        add_param(array, &params[i]);
    return true;
}

bool source_list(gen *g, const char *only, const gen_limits *limits, bool json, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    cJSON *kernels = cJSON_AddArrayToObject(o, "kernels");
    bool ok = true;
    const char *name = only ? only : gen_kernel(g, 0);
    for (uint32_t i = 0; ok && name; name = only ? NULL : gen_kernel(g, ++i))
        ok = add_kernel(kernels, g, name, limits, err);
    if (ok)
        return rendering_tell(o, json, "cli/report/kernels.lua", err);
    cJSON_Delete(o);
    return false;
}
