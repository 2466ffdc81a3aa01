// SPDX-License-Identifier: MIT
#include "cli/report/explain_search.h"

#include "cli/report/table.h"
#include "runtime/broadphase/world_explain.h"

#include <cjson/cJSON.h>
#include <inttypes.h>

static const char *const sides[] = {"A", "B"};

// ---------------------------------------------------------------- as tables

static void print_facts(const duet_world *world, int side)
{
    static const char *const heads[] = {"scene", "parameter", "what of it is in the kernels"};
    table t = table_begin("lll");
    for (int i = 0; i < 3; ++i)
        table_cell(&t, "%s", heads[i]);
    world_fact fact;
    for (uint32_t i = 0; world_fact_at(world, side, i, &fact); ++i) {
        table_cell(&t, "%s", fact.name);
        table_cell(&t, "%s=%" PRId64, fact.parameter, fact.value);
        table_cell(&t, "%s", fact.means);
    }
    table_print(&t, stdout);
}

static void print_kernels(const duet_world *world, int side)
{
    table t = table_begin("lll");
    world_kernel k;
    for (uint32_t i = 0; world_kernel_at(world, side, i, &k); ++i) {
        table_cell(&t, "%s", k.runs ? "runs" : "left out");
        table_cell(&t, "%s", k.why);
        table_cell(&t, "%s", k.name); // last: it is long
    }
    table_print(&t, stdout);
}

static void print(const duet_world *world, const duet_device_pair *pair)
{
    const duet_plan *plan = duet_world_get_plan(world);
    const char *variants[] = {plan->variant_a, plan->variant_b};
    for (int side = 0; side < 2; ++side) {
        if (!world->prepared[side])
            continue;
        printf("%s  %s, kernels '%s'\n\n", sides[side],
               duet_device_pair_get_info(pair, side)->selector, variants[side]);
        print_facts(world, side);
        printf("\n");
        print_kernels(world, side);
        printf("\n");
    }
}

// ---------------------------------------------------------------- as data

static cJSON *facts_json(const duet_world *world, int side)
{
    cJSON *list = cJSON_CreateArray();
    world_fact fact;
    for (uint32_t i = 0; world_fact_at(world, side, i, &fact); ++i) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", fact.name);
        cJSON_AddStringToObject(o, "parameter", fact.parameter);
        cJSON_AddNumberToObject(o, "value", (double)fact.value);
        cJSON_AddStringToObject(o, "means", fact.means);
        cJSON_AddItemToArray(list, o);
    }
    return list;
}

static cJSON *kernels_json(const duet_world *world, int side)
{
    cJSON *list = cJSON_CreateArray();
    world_kernel k;
    for (uint32_t i = 0; world_kernel_at(world, side, i, &k); ++i) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", k.name);
        cJSON_AddBoolToObject(o, "runs", k.runs);
        cJSON_AddStringToObject(o, "why", k.why);
        cJSON_AddItemToArray(list, o);
    }
    return list;
}

static void add_json(const duet_world *world, cJSON *o)
{
    const duet_plan *plan = duet_world_get_plan(world);
    const char *variants[] = {plan->variant_a, plan->variant_b};
    cJSON *search = cJSON_AddArrayToObject(o, "search");
    for (int side = 0; side < 2; ++side) {
        if (!world->prepared[side])
            continue;
        cJSON *its = cJSON_CreateObject();
        cJSON_AddStringToObject(its, "device", sides[side]);
        cJSON_AddStringToObject(its, "variant", variants[side]);
        cJSON_AddItemToObject(its, "facts", facts_json(world, side));
        cJSON_AddItemToObject(its, "kernels", kernels_json(world, side));
        cJSON_AddItemToArray(search, its);
    }
}

bool explain_search(const duet_world_def *def, const duet_scene *scene, cJSON *o, duet_error *err)
{
    duet_result result;
    duet_world *world = duet_world_create(def, err);
    bool ok =
        world && duet_world_set_scene(world, scene, err) && duet_world_step(world, &result, err);
    if (ok && o)
        add_json(world, o);
    else if (ok)
        print(world, def->pair);
    duet_world_destroy(world);
    return ok;
}
