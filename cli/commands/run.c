// SPDX-License-Identifier: MIT
// duet run: finds all pairs of a scene on two devices and says where the time went (run_still.c);
// with --steps it advances a scene that moves (run_motion.c).
#include "cli/commands/run.h"

#include "cli/commands.h"
#include "cli/commands/cluster.h"
#include "cli/frames.h"
#include "cli/say.h"
#include "cli/timed.h"

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    OPTION_INPUT("task", task, "FILE",
                 "run a kernel of your own: a task file (docs/tutorial_task.md)"),
    PAIR_OPTION_ROW(pair),
    PLAN_OPTION_ROWS(plan),
    SCENE_LEVEL_OPTION_ROWS(level),
    OPTION_COUNT("repeat", repeat, "K", "steps that are timed, after one to warm up (5)", 1,
                 100000),
    OPTION_TEXT("input", input, "I",
                "what each step is sent (host): host, resident, transforms or compact"),
    OPTION_FLAG("ordered", ordered, "put the objects into the order of their cells beforehand"),
    OPTION_COUNT("steps", steps, "K", "advance a moving scene by K steps", 1, 1000000000),
    OPTION_OUTPUT("picture", picture, "F.png", "draw the scene after the last step"),
    OPTION_TEXT("frames", frames, "DIR", "draw 30 pictures a second of the scene"),
    OPTION_TEXT("format", format, "F", "what frames are (png): png, or vtu, which ParaView opens"),
    OPTION_OUTPUT("record", record, "F.replay", "record commands, steps and the state's hash"),
    OPTION_INPUT("replay", replay, "F.replay", "replay recorded commands, and compare the hash"),
    OPTION_COUNT("every", every, "K", "save the motion each K steps", 1, 1000000000),
    OPTION_OUTPUT("checkpoint", checkpoint, "F", "where it is saved"),
    OPTION_TEXT("resume", resume, "F", "go on from a saved motion to step --steps"),
    OPTION_OUTPUT("pairs", pairs_path, "OUT.csv",
                  "write the pairs, a line each, ascending; - is stdout"),
    OPTION_OUTPUT("timeline", timeline, "F.svg",
                  "draw when each device of the step did what, as the paper's figures 10 and 11"),
    OPTION_FLAG("check", check, "compare the pairs with the plain C reference"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

// --steps advances a scene; without it one state is stepped again and again.
static const option_rule rules[] = {
    {"picture frames record replay checkpoint resume", OPTION_NEEDS, "steps"},
    {"every", OPTION_NEEDS, "checkpoint"},
    {"checkpoint", OPTION_NEEDS, "every"},
    {"checkpoint resume", OPTION_EXCLUDES, "replay"},
    {"frames", OPTION_EXCLUDES, "resume"},
    {"format", OPTION_NEEDS, "frames"},
    {"input ordered steps pairs check level missed false-rate", OPTION_EXCLUDES, "task"},
    {"repeat input ordered pairs timeline check level missed false-rate", OPTION_EXCLUDES, "steps"},
    {0},
};

// Pictures of bodies are of pixels. The reference knows no rotations that were rounded.
static const char *refuse(const void *given, char **operands)
{
    const arguments *args = given;
    timed_input input;
    frames_format format;
    (void)operands;
    if (args->picture && !text_ends_with(args->picture, ".png"))
        return "--picture: the name of a run's picture ends with .png";
    if (!timed_input_named(args->input, &input))
        return "--input: give host (all of the objects), resident (nothing: they stay on the "
               "devices), transforms (centres and rotations) or compact (the same in 20 bytes)";
    if (!frames_format_named(args->format, &format))
        return "--format: give png (pictures) or vtu (bodies and contacts for ParaView)";
    return args->check && input == TIMED_INPUT_COMPACT
               ? "--check and --input compact do not go together"
               : NULL;
}

static const command_line line = {
    .name = "run",
    .operands = "[SCENE|FILE]",
    .instead = "task",
    .about = "Finds all pairs of boxes that collide, on two devices, and says where the time\n"
             "went. With --steps moves the bodies of a scene.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
};

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    if (args->task)
        return run_task(args, err);
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(operands[0], &args->scene, err) : NULL;
    bool ok = scene && (args->steps > 0 ? run_motion(args, operands[0], scene, pair, err)
                                        : run_still(args, operands[0], scene, pair, err));
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return ok;
}

// Each rank would do all of the work. The first says so, and the others end as if all were well:
// a launcher ends the job with the first that fails.
static bool refuse_job(int *status)
{
    unsigned long rank = 0, n_ranks = 0;
    if (!cluster_job(&rank, &n_ranks) || n_ranks < 2)
        return false;
    *status = EXIT_OK;
    if (rank == 0)
        *status =
            say_wrong("run",
                      "this is an MPI job of %lu ranks, and each would find all pairs; expected "
                      "'mpirun -np %lu duet cluster'",
                      n_ranks, n_ranks);
    return true;
}

int command_run(int argc, char **argv)
{
    int status;
    if (refuse_job(&status))
        return status;
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT,
                      .plan = PLAN_OPTIONS_DEFAULT,
                      .level = LEVEL_OPTIONS_DEFAULT,
                      .input = "host",
                      .format = "png",
                      .repeat = 5};
    return options_run(&line, argc, argv, &args, run);
}
