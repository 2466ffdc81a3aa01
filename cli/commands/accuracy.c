// SPDX-License-Identifier: MIT
// duet accuracy: what accuracy costs in time. A scene that moves is run at each
// time step, against a much finer run; poses are searched at each level of
// accuracy on each device, against the exact pairs.
#include "base/error.h"
#include "cli/commands.h"
#include "cli/draw/canvas.h"
#include "cli/inputs.h"
#include "cli/report/level_costs_report.h"
#include "cli/report/rendering.h"
#include "cli/timestep_study.h"

enum { REPEAT = 9, TIME = 1, LIMIT = 120 };

typedef struct arguments {
    scene_options scene;
    const char *pair;
    uint64_t repeat; // 0: not given
    double time;     // below 0: not given, as the next
    double limit;
    bool still;
    const char *csv;
    const char *plot;
    bool json;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
    OPTION_COUNT("repeat", repeat, "K", "timed steps of each level and device, in turn (9)", 1,
                 LEVEL_COSTS_ROUNDS),
    OPTION_FLAG("still", still, "measure levels of accuracy of a moving scene, at its start"),
    OPTION_NUMBER("time", time, "S", "simulate S seconds of a moving scene with each time step (1)",
                  1e-6, 1e6),
    OPTION_NUMBER("limit", limit, "S", "start no other run after S seconds (120)", 0, 1e6),
    OPTION_OUTPUT("csv", csv, "OUT.csv", "write the table, a line each"),
    OPTION_OUTPUT("plot", plot, "OUT.svg", "draw it, as .svg or .png"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const option_rule rules[] = {{"time limit", OPTION_EXCLUDES, "still"}, {0}};

static const command_line line = {
    .name = "accuracy",
    .operands = "SCENE|FILE",
    .about = "Measures what accuracy costs. A still scene: the time of each level of accuracy,\n"
             "and what it gets wrong. A moving scene: time steps and substeps (in free flight\n"
             "integrators), how far each ends from a much finer run, how its energy drifts\n"
             "and how deep contacts get.",
    .options = options,
    .rules = rules,
};

// Whether a file is to be written to stdout, and nothing else.
static bool is_elsewhere(const arguments *args)
{
    return !args->json && (options_is_stdout(args->csv) || options_is_stdout(args->plot));
}

// The table, the plot and the report that were asked for of an object, which this deletes.
static bool tell(const arguments *args, cJSON *o, const char *report, const char *plot,
                 duet_error *err)
{
    static const char *const table[] = {"cli/report/read.lua", "cli/report/accuracy_csv.lua", NULL};
    bool ok = (!args->csv || rendering_write(args->csv, table, o, err)) &&
              (!args->plot || rendering_draw(args->plot, plot, o, err));
    if (ok && !is_elsewhere(args))
        return rendering_tell(o, args->json, report, err);
    cJSON_Delete(o);
    return ok;
}

static bool run_levels(const arguments *args, duet_device_pair *pair, const duet_scene *scene,
                       duet_error *err)
{
    level_costs p;
    return level_costs_show(&p, pair, scene, args->repeat ? (uint32_t)args->repeat : REPEAT, err) &&
           tell(args, level_costs_report_json(&p, duet_scene_get_info(scene), pair),
                "cli/report/levels.lua", "cli/report/levels_plot.lua", err);
}

static bool run_timesteps(const arguments *args, duet_device_pair *pair, const duet_scene *scene,
                          duet_error *err)
{
    timestep_study p;
    return timestep_study_measure(&p, pair, scene, args->time < 0 ? TIME : args->time,
                                  args->limit < 0 ? LIMIT : args->limit, err) &&
           tell(args, timestep_study_json(&p, duet_scene_get_info(scene), pair),
                "cli/report/timesteps.lua", "cli/report/timesteps_plot.lua", err);
}

// A plot that cannot be drawn is refused before minutes of measuring.
static bool check_plot(const char *path, duet_error *err)
{
    canvas *c = path ? canvas_open(path, 1, 1, err) : NULL;
    bool ok = !path || c;
    canvas_close(c, false, NULL);
    return ok;
}

static bool check_given(const arguments *args, bool moves, duet_error *err)
{
    if (moves && args->repeat > 0)
        return bad_argument(err, "--repeat is of the levels of a scene that does not move; this "
                                 "one moves (--still takes it as it begins)");
    return moves || args->still || (args->time < 0 && args->limit < 0) ||
           bad_argument(err, "--time and --limit are of a scene that moves; this one does not");
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    duet_device_pair *pair = check_plot(args->plot, err) ? inputs_open_pair(args->pair, err) : NULL;
    duet_scene *scene = pair ? inputs_load_scene(operands[0], &args->scene, err) : NULL;
    bool moves = false;
    bool ok = scene && (args->still || timestep_study_applies(pair, scene, &moves, err));
    ok = ok && check_given(args, moves, err);
    ok = ok && (moves ? run_timesteps : run_levels)(args, pair, scene, err);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return ok;
}

SUBCOMMAND(accuracy, .scene = SCENE_OPTIONS_DEFAULT, .time = -1, .limit = -1)
