// SPDX-License-Identifier: MIT
// duet accuracy: what each level of accuracy costs in time on each device, and
// what it gets wrong.
#include "tuner/cli/canvas.h"
#include "tuner/cli/commands.h"
#include "tuner/cli/inputs.h"
#include "tuner/cli/options.h"
#include "tuner/cli/prices_report.h"
#include "tuner/cli/say.h"

typedef struct arguments {
    scene_options scene;
    const char *pair;
    uint64_t repeat;
    const char *csv;
    const char *plot;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
    OPTION_COUNT("repeat", repeat, "K", "timed steps of each level and device, in turn (9)", 1,
                 PRICES_ROUNDS),
    OPTION_TEXT("csv", csv, "OUT.csv", "write the table, a line each"),
    OPTION_TEXT("plot", plot, "OUT.svg", "draw it, as .svg or .png"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line line = {
    .name = "accuracy",
    .operands = "SCENE|FILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Measures what each level of accuracy costs in time, and what it gets wrong.",
    .options = options,
};

static bool tell(const arguments *args, const prices_report *r, duet_error *err)
{
    bool ok = !args->csv || prices_report_csv(r, args->csv, err);
    ok = ok && (!args->plot || prices_report_plot(r, args->plot, err));
    if (ok && args->json)
        return prices_report_json(r, err);
    if (ok)
        prices_report_text(r);
    return ok;
}

// A plot that cannot be is told of before minutes are spent on it.
static bool check_plot(const char *path, duet_error *err)
{
    canvas *c = path ? canvas_open(path, 1, 1, err) : NULL;
    bool ok = !path || c;
    canvas_close(c, false, NULL);
    return ok;
}

static bool run(const arguments *args, const char *path, duet_error *err)
{
    prices p;
    duet_device_pair *pair = check_plot(args->plot, err) ? inputs_open_pair(args->pair, err) : NULL;
    duet_scene *scene = pair ? inputs_load_scene(path, &args->scene, err) : NULL;
    bool ok = scene && prices_measure(&p, pair, scene, (uint32_t)args->repeat, err);
    if (ok) {
        prices_report r = {duet_scene_describe(scene), pair, &p};
        ok = tell(args, &r, err);
    }
    duet_scene_destroy(scene);
    duet_device_pair_close(pair);
    return ok;
}

int command_accuracy(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .repeat = 9};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    return run(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
