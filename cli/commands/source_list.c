// SPDX-License-Identifier: MIT
#include "cli/commands/source.h"

#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <inttypes.h>
#include <stdio.h>

typedef struct listed {
    const char *name;
    const char *about;
    const gen_param *params;
    uint32_t n_params;
    uint64_t configs;
} listed;

static bool ask(gen *g, const char *name, const gen_limits *limits, listed *k, duet_error *err)
{
    k->name = name;
    return gen_about(g, name, &k->about, err) && gen_count(g, name, limits, &k->configs, err) &&
           gen_params(g, name, limits, &k->params, &k->n_params, err);
}

// "1 64 [128] 256", the default in brackets; "0 .. 31 [0]" for a range.
static void add_values(const gen_param *p, text *out)
{
    if (p->is_range)
        text_add(out, "%" PRId64 " .. %" PRId64 " [%" PRId64 "]", p->least, p->most, p->fallback);
    for (uint32_t i = 0; !p->is_range && i < p->n_values; ++i)
        text_add(out, p->values[i] == p->fallback ? "%s[%" PRId64 "]" : "%s%" PRId64, i ? " " : "",
                 p->values[i]);
}

static bool print_kernel(const listed *k, duet_error *err)
{
    printf("%s  %s\n", k->name, k->about);
    table t = table_begin("llll");
    text values = {0};
    for (uint32_t i = 0; i < k->n_params; ++i) {
        values.length = 0;
        add_values(&k->params[i], &values);
        table_words(&t, " ", k->params[i].name, text_chars(&values), k->params[i].about, NULL);
    }
    table_print(&t, stdout);
    printf("  %" PRIu64 " valid config%s\n\n", k->configs, k->configs == 1 ? "" : "s");
    bool ok = text_ok(&values, err);
    text_free(&values);
    return ok;
}

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

static void add_kernel(cJSON *list, const listed *k)
{
    cJSON *o = json_add_row(list);
    json_add(o, STRING("name", k->name), STRING("about", k->about), NUMBER("configs", k->configs));
    cJSON *params = cJSON_AddArrayToObject(o, "params");
    for (uint32_t i = 0; i < k->n_params; ++i)
        add_param(params, &k->params[i]);
}

bool source_list(gen *g, const char *only, const gen_limits *limits, bool json, duet_error *err)
{
    cJSON *o = json ? cJSON_CreateObject() : NULL;
    cJSON *kernels = o ? cJSON_AddArrayToObject(o, "kernels") : NULL;
    bool ok = true;
    const char *name = only ? only : gen_kernel(g, 0);
    for (uint32_t i = 0; ok && name; name = only ? NULL : gen_kernel(g, ++i)) {
        listed k;
        ok = ask(g, name, limits, &k, err);
        if (ok && o)
            add_kernel(kernels, &k);
        else if (ok)
            ok = print_kernel(&k, err);
    }
    if (ok && o)
        return say_json(o, err);
    cJSON_Delete(o);
    return ok;
}
