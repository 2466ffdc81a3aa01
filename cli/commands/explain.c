// SPDX-License-Identifier: MIT
// duet explain: what a scene calls for, by what, and what it costs. A scene that
// moves calls for effects, a still one for the kernels that find its pairs. explain_task.c has
// --task.
#include "base/error.h"
#include "cli/commands.h"
#include "cli/commands/explain_task.h"
#include "cli/costs.h"
#include "cli/inputs.h"
#include "cli/report/rendering.h"
#include "runtime/broadphase/world_explain.h"

typedef struct arguments {
    scene_options scene;
    const char *task; // a task file; NULL: a scene is explained
    const char *pair;
    plan_options plan;
    const char *level;
    bool measure;
    uint64_t steps;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    OPTION_INPUT("task", task, "FILE", "explain a kernel of your own: a task file"),
    PAIR_OPTION_ROW(pair),
    PLAN_OPTION_ROWS(plan),
    LEVEL_OPTION_ROW(level),
    OPTION_FLAG("measure", measure, "run the scene with and without each effect, and compare"),
    OPTION_COUNT("steps", steps, "K", "steps of each such run (20)", 3, 100000),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const option_rule rules[] = {
    {"steps", OPTION_NEEDS, "measure"},
    {"share mode variant variant-a variant-b level measure", OPTION_EXCLUDES, "task"},
    {0},
};

static const command_line line = {
    .name = "explain",
    .operands = "[SCENE|FILE]",
    .instead = "task",
    .about = "Shows what a scene calls for. A moving scene has effects: what calls for each,\n"
             "its kernels and its bytes an object. A still scene has kernels that find its\n"
             "pairs, kernels left out, and the property of the scene that decides it. A task\n"
             "has arguments, and parameters of its kernel to choose from.",
    .options = options,
    .rules = rules,
};

// ---------------------------------------------------------------- a still scene

static const char *const sides[] = {"A", "B"};

static void add_facts(cJSON *o, const duet_world *world, int side)
{
    cJSON *list = cJSON_AddArrayToObject(o, "facts");
    world_fact fact;
    for (uint32_t i = 0; world_fact_at(world, side, i, &fact); ++i) {
        cJSON *row = json_add_row(list);
        json_add(row, STRING("name", fact.name), STRING("parameter", fact.parameter),
                 NUMBER("value", fact.value), STRING("means", fact.means));
    }
}

static void add_kernels(cJSON *o, const duet_world *world, int side)
{
    cJSON *list = cJSON_AddArrayToObject(o, "kernels");
    world_kernel k;
    for (uint32_t i = 0; world_kernel_at(world, side, i, &k); ++i) {
        cJSON *row = json_add_row(list);
        json_add(row, STRING("name", k.name), FLAG("runs", k.runs), STRING("why", k.why));
    }
}

static void add_json(const duet_world *world, cJSON *o)
{
    const duet_plan *plan = duet_world_get_plan(world);
    const char *variants[] = {plan->variant_a, plan->variant_b};
    cJSON *search = cJSON_AddArrayToObject(o, "search");
    for (int side = 0; side < 2; ++side) {
        if (!world_is_prepared(world, side))
            continue;
        cJSON *its = json_add_row(search);
        json_add(its, STRING("device", sides[side]), STRING("variant", variants[side]));
        add_facts(its, world, side);
        add_kernels(its, world, side);
    }
}

// Steps the scene once in such a world, and adds "search" to o: what is then compiled in and
// launched.
static bool explain_search(const duet_world_def *def, const duet_scene *scene, cJSON *o,
                           duet_error *err)
{
    duet_result result;
    duet_world *world = duet_world_create(def, err);
    bool ok =
        world && duet_world_set_scene(world, scene, err) && duet_world_step(world, &result, err);
    if (ok)
        add_json(world, o);
    duet_world_destroy(world);
    return ok;
}

// ---------------------------------------------------------------- the command

// Corners do not move, and have no effects to measure.
static bool tell_effects(costs *c, const arguments *args, duet_device_pair *pair,
                         const duet_scene *scene, duet_error *err)
{
    *c = (costs){.n = 0};
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    return !duet_scene_get_objects(scene, DUET_OBJECT_POSES) ||
           (inputs_change_plan(&args->plan, pair, args->pair, &def.plan, err) &&
            costs_measure(c, &def, scene, args->measure ? args->steps : 0, err));
}

static bool is_still(const costs *c)
{
    for (uint32_t i = 0; i < c->n; ++i)
        if (c->rows[i].info.active)
            return false;
    return true;
}

static bool check_given(const arguments *args, bool still, duet_error *err)
{
    if (still && args->measure)
        return bad_argument(err, "--measure is of a scene that moves; this one does not");
    return still || !args->level ||
           bad_argument(err, "--level is of a scene that does not move; this one moves");
}

static bool tell_search(const arguments *args, duet_device_pair *pair, const duet_scene *scene,
                        cJSON *o, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(scene, pair);
    return inputs_read_level(args->level, &def.level, err) &&
           inputs_change_plan(&args->plan, pair, args->pair, &def.plan, err) &&
           explain_search(&def, scene, o, err);
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    costs c;
    if (args->task)
        return explain_task(args->task, &args->scene, args->pair, args->json, err);
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(operands[0], &args->scene, err) : NULL;
    bool ok = scene && tell_effects(&c, args, pair, scene, err);
    bool still = ok && is_still(&c);
    ok = ok && check_given(args, still, err);
    cJSON *o = ok ? costs_report_json(&c, duet_scene_get_info(scene), pair) : NULL;
    ok = ok && (!still || tell_search(args, pair, scene, o, err));
    if (ok)
        ok = rendering_tell(o, args->json, "cli/report/explain.lua", err);
    else
        cJSON_Delete(o);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return ok;
}

SUBCOMMAND(explain, .scene = SCENE_OPTIONS_DEFAULT, .plan = PLAN_OPTIONS_DEFAULT, .steps = 20)
