// SPDX-License-Identifier: MIT
// duet explain: which effects a scene calls for, by what, and what each costs.
#include "tuner/cli/commands.h"
#include "tuner/cli/costs_report.h"
#include "tuner/cli/inputs.h"
#include "tuner/cli/options.h"
#include "tuner/cli/say.h"

typedef struct arguments {
    scene_options scene;
    const char *pair;
    bool measure;
    uint64_t steps;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
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
    .about = "Tells the effects that a scene calls for: why, their kernels, bytes an object.",
    .options = options,
};

static bool explain(const arguments *args, const char *path, duet_error *err)
{
    costs c;
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(path, &args->scene, err) : NULL;
    bool ok = scene && costs_measure(&c, pair, scene, args->measure ? args->steps : 0, err);
    if (ok && args->json)
        ok = say_json(costs_report_json(&c, duet_scene_describe(scene), pair), err);
    else if (ok)
        costs_report_text(&c);
    duet_scene_destroy(scene);
    duet_device_pair_close(pair);
    return ok;
}

int command_explain(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .steps = 20};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    return explain(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
