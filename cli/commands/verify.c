// SPDX-License-Identifier: MIT
// duet verify: runs a moving scene twice, step beside step, and says that all states were equal, or
// what differed first.
//
// States are compared each so many steps, and kept where they are equal. Once they differ both runs
// go back to what was kept, and then half of the steps in between, until one step is left. Over
// ranks jobs make the steps, and the runs' motions hold what is told of their states.
#include "cli/commands.h"

#include "base/error.h"
#include "cli/commands/cluster.h"
#include "cli/difference.h"
#include "cli/interrupt.h"
#include "cli/report/json.h"
#include "cli/say.h"
#include "cli/verified_jobs.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

typedef struct arguments {
    scene_options scene;
    uint64_t steps;       // 0: all that are recorded
    uint64_t every;       // steps from one comparison to the next
    uint64_t ranks;       // 0: not given, as is
    uint64_t other_ranks; // if neither is given, this process makes the steps
    const char *replay;
    const char *other_replay;
    const char *pair;
    const char *other_pair;
    plan_options plan;
    plan_options other_plan;
    bool json;
    int status; // of a job that has told why it failed
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    OPTION_COUNT("steps", steps, "K", "steps to compare (all that are recorded)", 1, 1000000000),
    OPTION_COUNT("every", every, "K", "compare the states after each K steps (64)", 1, 1000000000),
    OPTION_INPUT("replay", replay, "F.replay", "replay recorded commands in both runs"),
    OPTION_INPUT("other-replay", other_replay, "F.replay", "commands of the other run"),
    PAIR_OPTION_ROW(pair),
    PLAN_OPTION_ROWS(plan),
    OPTION_TEXT("other-pair", other_pair, "A,B", "devices of the other run"),
    OPTION_SHARE("other-share", other_plan.share, "R", "A's part of the other run's work"),
    OPTION_TEXT("other-mode", other_plan.mode, "M",
                "the other run's: shared, own, slab or default"),
    OPTION_TEXT("other-variant", other_plan.variant, "V", "kernels of the other run"),
    OPTION_TEXT("other-variant-a", other_plan.variants[0], "V", "kernels of its A"),
    OPTION_TEXT("other-variant-b", other_plan.variants[1], "V", "kernels of its B"),
    OPTION_COUNT("ranks", ranks, "R", "run on R ranks of this machine, by mpirun", 1, 65536),
    OPTION_COUNT("other-ranks", other_ranks, "R", "ranks of the other run (1)", 1, 65536),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const option_rule rules[] = {
    {"other-replay", OPTION_NEEDS, "replay"},
    {0},
};

static const char *refuse(const void *given, char **operands)
{
    const arguments *args = given;
    if ((args->ranks > 0 || args->other_ranks > 0) && strcmp(operands[0], "-") == 0)
        return "--ranks: the scene is read more than once; expected a file or a scene's name";
    return args->steps > 0 || args->replay ? NULL
                                           : "--steps is missing; give it, or --replay F.replay";
}

static const command_line line = {
    .name = "verify",
    .operands = "SCENE|FILE",
    .about = "Runs a moving scene twice, on two device pairs, by two plans or on two numbers of\n"
             "ranks, and says whether every step gave the same bits, or the first step, stage\n"
             "and body that differ.\n"
             "Without options of the other run that is on two devices: halves of the CPU, or\n"
             "a device that is taken twice.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
};

typedef struct verification verification;

// How both runs are moved: by this process, or by jobs over ranks.
typedef struct mover {
    // Takes steps up to one, or less far where something ends the runs before. *differ: something
    // does, or is no longer finite.
    bool (*go)(verification *v, uint64_t step, bool *differ, duet_error *err);
    // Takes the next step, and finds what differs in it.
    bool (*compare_step)(verification *v, duet_error *err);
    // Keeps both states, which are equal; goes back to them.
    bool (*keep)(verification *v, duet_error *err);
    bool (*go_back)(verification *v, duet_error *err);
} mover;

struct verification {
    const arguments *args;
    const mover *by;
    const duet_scene *scene;
    verified_run runs[2];
    verified_jobs jobs; // make the steps if runs have ranks
    uint64_t steps, done;
    uint64_t kept;  // the step at which both states were kept
    uint64_t taken; // steps that each run made in all
    difference first;
    progress shown;
    char twice[160]; // selectors of the other run
};

static const mover here, by_jobs;

// ---------------------------------------------------------------- two runs

// Both runs have ranks, or none has.
static void take_ranks(verification *v)
{
    const uint64_t ranks[2] = {v->args->ranks, v->args->other_ranks};
    v->by = ranks[0] > 0 || ranks[1] > 0 ? &by_jobs : &here;
    for (int i = 0; i < 2 && v->by == &by_jobs; ++i)
        v->runs[i].ranks = ranks[i] > 0 ? ranks[i] : 1;
}

// Without options of its own the other run divides what the first does on one device, and does on
// one device what the first divides.
static void choose_other(verification *v)
{
    const verified_run *first = &v->runs[0];
    verified_run *other = &v->runs[1];
    if (v->by == &by_jobs || other->selectors || inputs_plan_given(&other->plan) ||
        v->args->other_replay)
        return;
    const duet_device_info *b = duet_device_pair_get_info(first->pair, 1);
    if (inputs_motion_plan(first->motion).share > 0) {
        other->plan.share = 0;
        return;
    }
    if (duet_device_pair_is_one(first->pair)) {
        snprintf(v->twice, sizeof v->twice, "%s,%s", b->selector, b->selector);
        bool halves = b->kind == DUET_KIND_CPU && b->can_cut && b->units > 1;
        other->selectors = halves ? "halves" : v->twice;
    }
    other->plan.share = DUET_SHARE_ONE / 2;
    other->plan.mode = "slab";
}

static bool count_steps(verification *v, duet_error *err)
{
    v->steps = v->args->steps;
    for (int i = 0; i < 2 && v->args->replay; ++i) {
        const verified_run *r = &v->runs[i];
        const uint64_t recorded = duet_replay_get_info(r->replay).steps;
        if (!inputs_check_recorded(r->replay, r->path, v->args->steps, err))
            return false;
        v->steps = v->steps == 0 || recorded < v->steps ? recorded : v->steps;
    }
    return true;
}

static bool open_runs(verification *v, duet_error *err)
{
    const arguments *args = v->args;
    v->runs[0] = (verified_run){.selectors = args->pair, .plan = args->plan, .path = args->replay};
    v->runs[1] = (verified_run){.selectors = args->other_pair,
                                .plan = args->other_plan,
                                .path = args->other_replay ? args->other_replay : args->replay};
    take_ranks(v);
    if ((v->by == &by_jobs && !cluster_may_start(err)) ||
        !verified_run_open(&v->runs[0], v->scene, err))
        return false;
    choose_other(v);
    if (!v->runs[1].selectors)
        v->runs[1].selectors = args->pair;
    return verified_run_open(&v->runs[1], v->scene, err) && count_steps(v, err);
}

// ---------------------------------------------------------------- comparing

typedef bool run_call(verified_run *r, duet_error *err);

static bool call_both(verification *v, run_call *call, duet_error *err)
{
    return call(&v->runs[0], err) && call(&v->runs[1], err);
}

// A state that is not finite in both runs ends them.
static bool both_finite(const verification *v, duet_error *err)
{
    const duet_error *why = &v->runs[0].not_finite;
    return why->status == DUET_STATUS_OK || v->runs[1].not_finite.status == DUET_STATUS_OK ||
           error_copy(err, why);
}

static bool compare_states(verification *v, const char *stage, uint64_t step, duet_error *err)
{
    v->first.step = step;
    return call_both(v, verified_run_sum, err) && both_finite(v, err) &&
           (!difference_is(v->runs, false) ||
            difference_find_state(&v->first, v->runs, stage, err));
}

// ---------------------------------------------------------------- by this process

// Looks between the stages, too.
static bool compare_step(verification *v, duet_error *err)
{
    const uint64_t step = v->done + 1;
    if (!call_both(v, verified_run_command, err))
        return false;
    bool commanded = v->runs[0].commanded || v->runs[1].commanded;
    if (commanded && !compare_states(v, "commands", step, err))
        return false;
    v->first.step = step;
    return v->first.stage ||
           (call_both(v, verified_run_step, err) && call_both(v, verified_run_sum, err) &&
            both_finite(v, err) &&
            (!difference_is(v->runs, true) || difference_find(&v->first, v->runs, err)));
}

// A run that parts from its recording ends both.
static bool is_unlike(const verification *v)
{
    return v->runs[0].unlike.status != DUET_STATUS_OK || v->runs[1].unlike.status != DUET_STATUS_OK;
}

static bool take_step(verification *v, duet_error *err)
{
    if (!interrupt_check(err) || !call_both(v, verified_run_command, err) ||
        !call_both(v, verified_run_step, err))
        return false;
    ++v->done;
    ++v->taken;
    progress_show(&v->shown, v->done);
    return true;
}

static bool is_bad(const verified_run *r)
{
    return r->not_finite.status != DUET_STATUS_OK;
}

// Ends where events differ, or a run parts from its recording.
static bool take_steps(verification *v, uint64_t step, bool *differ, duet_error *err)
{
    bool ok = true;
    *differ = false;
    while (ok && !*differ && v->done < step && !is_unlike(v)) {
        ok = take_step(v, err);
        *differ = ok && difference_is_told(v->runs);
    }
    ok = ok && call_both(v, verified_run_sum, err);
    *differ = ok && (difference_is(v->runs, true) || is_bad(&v->runs[0]));
    return ok;
}

static bool keep_motions(verification *v, duet_error *err)
{
    v->kept = v->done;
    return call_both(v, verified_run_keep, err);
}

static bool return_motions(verification *v, duet_error *err)
{
    v->done = v->kept;
    return call_both(v, verified_run_return, err);
}

static const mover here = {take_steps, compare_step, keep_motions, return_motions};

// ---------------------------------------------------------------- by jobs

static bool run_jobs(verification *v, uint64_t step, bool *differ, duet_error *err)
{
    if (!interrupt_check(err) || !verified_jobs_go(&v->jobs, v->runs, v->kept, step, differ, err))
        return false;
    v->taken += step - v->kept;
    v->done = step;
    return true;
}

// Reads the states that the jobs reached into the motions.
static bool read_checkpoints(verification *v, duet_error *err)
{
    return verified_jobs_load(&v->jobs, v->runs, err) && call_both(v, verified_run_sum, err) &&
           both_finite(v, err);
}

// Finds something that has a stage, or else a byte of the checkpoints.
static bool find_in_checkpoints(verification *v, duet_error *err)
{
    difference *d = &v->first;
    if (!read_checkpoints(v, err) || !difference_find(d, v->runs, err))
        return false;
    if (d->stage)
        return true;
    d->stage = "checkpoint";
    d->body = DUET_NO_BODY;
    snprintf(d->field, sizeof d->field, "byte %zu", v->jobs.unlike.at);
    memcpy(d->values, v->jobs.unlike.bytes, sizeof d->values);
    return true;
}

static bool compare_checkpoints(verification *v, duet_error *err)
{
    bool differ = false;
    v->first.step = v->done + 1;
    return verified_jobs_go(&v->jobs, v->runs, v->done, v->first.step, &differ, err) &&
           (!differ || find_in_checkpoints(v, err));
}

static bool keep_checkpoint(verification *v, duet_error *err)
{
    v->kept = v->done;
    return v->kept == 0 || (read_checkpoints(v, err) && verified_jobs_keep(&v->jobs, err));
}

static bool return_to_checkpoint(verification *v, duet_error *err)
{
    (void)err; // jobs go on from the file
    v->done = v->kept;
    return true;
}

static const mover by_jobs = {run_jobs, compare_checkpoints, keep_checkpoint, return_to_checkpoint};

// ---------------------------------------------------------------- both

static void forget_unlike(verification *v)
{
    for (int i = 0; i < 2; ++i)
        v->runs[i].unlike = (duet_error){0};
}

// The states differ at step `differs`, and did not where they were kept: halves the way.
static bool find_first(verification *v, uint64_t differs, duet_error *err)
{
    bool ok = v->by->go_back(v, err);
    while (ok && differs - v->kept > 1) {
        bool differ = false;
        forget_unlike(v);
        ok = v->by->go(v, v->kept + (differs - v->kept) / 2, &differ, err);
        if (differ)
            differs = v->done;
        ok = ok && (differ ? v->by->go_back(v, err) : v->by->keep(v, err));
    }
    ok = ok && v->by->compare_step(v, err);
    ++v->taken;
    return ok && (v->first.stage ||
                  error_set(err, DUET_STATUS_WRONG_RESULT,
                            "different: step %" PRIu64 ", but not when both runs took it again "
                            "from the state before: one of them does not repeat itself",
                            v->done + 1));
}

static bool is_over(const verification *v)
{
    return v->first.stage || is_unlike(v) || v->done == v->steps;
}

static bool compare(verification *v, duet_error *err)
{
    bool ok = compare_states(v, "start", 0, err) && (v->first.stage || v->by->keep(v, err));
    v->shown = progress_begin("step", v->steps);
    while (ok && !is_over(v)) {
        const uint64_t next = v->done + v->args->every;
        bool differ = false;
        ok = v->by->go(v, next < v->steps ? next : v->steps, &differ, err);
        if (ok && differ)
            ok = find_first(v, v->done, err);
        else if (ok)
            ok = v->by->keep(v, err);
    }
    progress_end(&v->shown);
    return ok;
}

// ---------------------------------------------------------------- telling

static void add_run(cJSON *row, const verified_run *r)
{
    const duet_plan plan = inputs_motion_plan(r->motion);
    if (r->ranks > 0) {
        json_add(row, NUMBER("ranks", (double)r->ranks));
        return;
    }
    json_add_devices(row, r->pair);
    json_add_plan(row, plan.share / (double)DUET_SHARE_ONE, duet_mode_name(plan.mode),
                  plan.variant_a, plan.variant_b);
}

static bool tell_json(const verification *v, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("type", "duet verify"), STRING("scene", duet_scene_get_info(v->scene)->name),
             NUMBER("objects", duet_motion_get_count(v->runs[0].motion)),
             NUMBER("steps", (double)(v->first.stage ? v->first.step : v->done)),
             NUMBER("steps_taken", (double)v->taken), FLAG("equal", !v->first.stage));
    if (!v->first.stage)
        json_add_hash(o, v->runs[0].hash);
    cJSON *list = cJSON_AddArrayToObject(o, "runs");
    for (int i = 0; i < 2; ++i)
        add_run(json_add_row(list), &v->runs[i]);
    if (v->first.stage) {
        json_add(o, STRING("stage", v->first.stage));
        if (v->first.body != DUET_NO_BODY)
            json_add(o, NUMBER("body", v->first.body));
        json_add(o, STRING("field", v->first.field));
        json_add(o, NUMBER("first", v->first.values[0]), NUMBER("other", v->first.values[1]));
    }
    return say_json(o, err);
}

static void tell_runs(const verification *v, text *to)
{
    verified_run_tell(&v->runs[0], to);
    text_add(to, " and ");
    verified_run_tell(&v->runs[1], to);
}

static bool tell_equal(const verification *v, duet_error *err)
{
    text runs = {0};
    tell_runs(v, &runs);
    bool ok = text_ok(&runs, err);
    uint32_t n = duet_motion_get_count(v->runs[0].motion);
    if (ok && !v->args->json)
        printf("equal: %s, %s, state hash %016" PRIx64 ": %s\n",
               say_things(v->done, "step", "steps").chars, say_things(n, "body", "bodies").chars,
               v->runs[0].hash, runs.chars);
    text_free(&runs);
    return ok;
}

static bool tell_difference(const verification *v, duet_error *err)
{
    text told = {0};
    difference_tell(&v->first, &told);
    text_add(&told, ": ");
    tell_runs(v, &told);
    error_set(err, DUET_STATUS_WRONG_RESULT, "different: %s", text_chars(&told));
    text_free(&told);
    return false;
}

// Runs that are equal to each other can both differ from what was recorded.
static bool tell(const verification *v, duet_error *err)
{
    if (v->args->json && !tell_json(v, err))
        return false;
    if (v->first.stage)
        return tell_difference(v, err);
    const duet_error *unlike = &v->runs[v->runs[0].unlike.status == DUET_STATUS_OK].unlike;
    return tell_equal(v, err) && (unlike->status == DUET_STATUS_OK || error_copy(err, unlike));
}

static bool run(void *given, char **operands, duet_error *err)
{
    arguments *args = given;
    verification v = {.args = args};
    duet_scene *scene = inputs_load_scene(operands[0], &args->scene, err);
    v.scene = scene;
    bool ok = scene && open_runs(&v, err) &&
              (v.by == &here || verified_jobs_open(&v.jobs, operands[0], &args->scene, err)) &&
              compare(&v, err) && tell(&v, err);
    args->status = v.jobs.status;
    verified_jobs_close(&v.jobs);
    verified_run_close(&v.runs[0]);
    verified_run_close(&v.runs[1]);
    duet_scene_destroy(scene);
    return ok || args->status != EXIT_OK;
}

int command_verify(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT,
                      .every = 64,
                      .plan = PLAN_OPTIONS_DEFAULT,
                      .other_plan = {.share = UINT32_MAX, .prefix = "other-"}};
    int status = options_run(&line, argc, argv, &args, run);
    return status == EXIT_OK ? args.status : status;
}
