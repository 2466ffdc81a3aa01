// SPDX-License-Identifier: MIT
// duet explain: what a scene calls for, by what, and what it costs. A scene that
// moves calls for effects, a still one for the kernels that find its pairs.
#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/options.h"
#include "cli/report/costs_report.h"
#include "cli/report/explain_search.h"
#include "cli/say.h"

typedef struct arguments {
    scene_options scene;
    const char *pair;
    plan_options plan;
    const char *level;
    bool measure;
    uint64_t steps;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
    PLAN_OPTION_ROWS(plan),
    LEVEL_OPTION_ROW(level),
    OPTION_FLAG("measure", measure, "run the scene with and without each effect, and compare"),
    OPTION_COUNT("steps", steps, "K", "steps of each such run (20)", 3, 100000),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "explain",
    .operands = "SCENE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Tells what a scene calls for. Of one that moves: its effects, why, their kernels,\n"
             "bytes an object. Of a still one: the kernels that find its pairs and those that\n"
             "are left out, which property of the scene decides what, and what that means.",
    .options = options,
};

// Corners do not move, and have no effects to measure.
static bool tell_effects(costs *c, const arguments *args, duet_device_pair *pair,
                         const duet_scene *scene, duet_error *err)
{
    *c = (costs){.n = 0};
    return (!duet_scene_get_objects(scene, DUET_OBJECT_POSES) && !args->measure) ||
           costs_measure(c, pair, scene, args->measure ? args->steps : 0, err);
}

static bool is_still(const costs *c)
{
    for (uint32_t i = 0; i < c->n; ++i)
        if (c->rows[i].info.active)
            return false;
    return true;
}

static bool tell_search(const arguments *args, duet_device_pair *pair, const duet_scene *scene,
                        cJSON *o, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(scene, pair);
    return inputs_read_level(args->level, &def.level, err) &&
           inputs_change_plan(&args->plan, &def.plan, err) && explain_search(&def, scene, o, err);
}

static bool explain(const arguments *args, const char *path, duet_error *err)
{
    costs c;
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(path, &args->scene, err) : NULL;
    bool ok = scene && tell_effects(&c, args, pair, scene, err);
    bool still = ok && is_still(&c);
    cJSON *o = ok && args->json ? costs_report_json(&c, duet_scene_get_info(scene), pair) : NULL;
    if (ok && still)
        ok = tell_search(args, pair, scene, o, err);
    else if (ok && !o)
        costs_report_text(&c);
    if (ok && o)
        ok = say_json(o, err);
    else
        cJSON_Delete(o);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return ok;
}

int command_explain(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .plan = PLAN_OPTIONS_DEFAULT, .steps = 20};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    return explain(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
