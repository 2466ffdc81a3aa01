// SPDX-License-Identifier: MIT
// The pairs of a scene that stands still, and where the time goes. The first step warms up; of the
// others the one with the median time is shown, so that its stages belong together.
#include "cli/commands/run.h"

#include "base/error.h"
#include "base/text.h"
#include "cli/command_text.h"
#include "cli/interrupt.h"
#include "cli/report/run_report.h"
#include "cli/report/time_lines.h"
#include "cli/say.h"
#include "runtime/scene/sorted_pairs.h"

#include <inttypes.h>
#include <stdlib.h>

typedef struct still {
    const arguments *args;
    const char *path;
    duet_scene *scene;
    duet_device_pair *pair;
    uint32_t *ids;     // names of the objects before they were put in order; NULL: they were not
    run_report report; // tells of its world and steps
} still;

// ---------------------------------------------------------------- the world

static bool put_in_order(still *s, duet_error *err)
{
    return !s->args->ordered || inputs_put_in_order(s->scene, s->pair, &s->ids, err);
}

static bool make_world(still *s, duet_error *err)
{
    const arguments *args = s->args;
    duet_world_def def = duet_scene_world_def(s->scene, s->pair);
    if (!inputs_change_level(&args->level, &def, err) ||
        !inputs_change_plan(&args->plan, s->pair, args->pair, &def.plan, err))
        return false;
    def.pose_form = s->report.input == TIMED_INPUT_TRANSFORMS ? DUET_POSE_TRANSFORM
                    : s->report.input == TIMED_INPUT_COMPACT  ? DUET_POSE_COMPACT
                                                              : DUET_POSE_WHOLE;
    def.ordered = args->ordered;
    s->report.world = duet_world_create(&def, err);
    if (!s->report.world)
        return false;
    bool idle_a =
        duet_device_pair_is_one(s->pair) && duet_world_get_plan(s->report.world)->share == 0;
    return !idle_a || !args->plan.variants[0] ||
           bad_argument(
               err, "--variant-a: A and B are one device, which works as B; expected --variant");
}

// A plan that was given is kept; else the world gets the one that was measured.
static bool choose_plan(still *s, duet_error *err)
{
    run_report *r = &s->report;
    r->profile.grade = DUET_GRADE_DEFAULT;
    if (inputs_plan_given(&s->args->plan) || r->scene->n == 0)
        return true;
    if (!duet_world_set_scene(r->world, s->scene, err))
        return false;
    duet_error failure = {0};
    return duet_world_load_profile(r->world, NULL, &r->profile, &failure) ||
           inputs_do_without_profile(&failure, err);
}

// ---------------------------------------------------------------- its pairs

static bool write_pairs(const char *path, const duet_pair *pairs, uint64_t n, duet_error *err)
{
    text lines = {0};
    for (uint64_t i = 0; i < n; ++i)
        text_add(&lines, "%" PRIu32 ",%" PRIu32 "\n", pairs[i].a, pairs[i].b);
    return say_to_file(&lines, path, err);
}

static bool compare(still *s, const duet_pair *pairs, uint64_t n, duet_error *err)
{
    reference_check *check = &s->report.check;
    duet_pair *expected = NULL;
    if (!inputs_find_reference(s->scene, duet_world_get_level(s->report.world), &expected,
                               &check->reference, err))
        return false;
    sorted_pairs_count wrong = {0};
    sorted_pairs_compare(pairs, n, expected, check->reference, sorted_pairs_count_wrong, &wrong);
    check->extra = wrong.added;
    check->missing = wrong.missed;
    duet_free(expected);
    return true;
}

// The pairs' ids are those that objects had before they were put in order.
static bool find_own_hash(still *s, duet_error *err)
{
    timed *t = &s->report.timed;
    duet_pair *pairs = sorted_pairs_of(&t->last, err);
    if (!pairs)
        return false;
    sorted_pairs_rename(pairs, t->last.pairs, s->ids);
    t->hash = duet_pairs_hash(pairs, t->last.pairs);
    free(pairs);
    return true;
}

static bool use_pairs(still *s, duet_error *err)
{
    const arguments *args = s->args;
    const duet_result *result = &s->report.timed.last;
    if (!args->check && !args->pairs_path)
        return true;
    duet_pair *pairs = sorted_pairs_of(result, err);
    bool ok = pairs != NULL;
    if (ok && args->check)
        ok = compare(s, pairs, result->pairs, err);
    if (ok && args->pairs_path && s->ids)
        sorted_pairs_rename(pairs, result->pairs, s->ids);
    if (ok && args->pairs_path)
        ok = write_pairs(args->pairs_path, pairs, result->pairs, err);
    free(pairs);
    return ok;
}

// ---------------------------------------------------------------- what is told

static void write_tuning(still *s)
{
    text *tuning = &s->report.tuning;
    text_add(tuning, "duet tune");
    command_text_scene(tuning, s->path, &s->args->scene);
    command_text_pair(tuning, s->pair);
    command_text_level(tuning, &s->args->level);
    if (s->args->ordered)
        text_add(tuning, " --ordered");
}

// The time lines are of the step whose stages the report has.
static bool tell(const still *s, duet_error *err)
{
    const run_report *r = &s->report;
    if (!time_lines_write(s->args->timeline, r->scene->name, s->pair, duet_world_get_plan(r->world),
                          timed_staged(&s->report.timed), err))
        return false;
    bool elsewhere = !s->args->json && (options_is_stdout(s->args->pairs_path) ||
                                        options_is_stdout(s->args->timeline));
    if (!elsewhere && !run_report_tell(r, err))
        return false;
    return reference_check_is_right(&r->check) ||
           error_set(err, DUET_STATUS_WRONG_RESULT, "%s: the pairs differ from the reference's",
                     r->scene->name);
}

// The profile that is chosen may bring a level.
static bool step(still *s, duet_error *err)
{
    run_report *r = &s->report;
    write_tuning(s);
    return choose_plan(s, err) &&
           timed_run(&r->timed, r->world, s->scene, (uint32_t)s->args->repeat, r->input, err) &&
           (!s->ids || find_own_hash(s, err)) && use_pairs(s, err);
}

bool run_still(const arguments *args, const char *path, duet_scene *scene, duet_device_pair *pair,
               duet_error *err)
{
    still s = {.args = args, .path = path, .scene = scene, .pair = pair};
    run_report *r = &s.report;
    *r = (run_report){.args = args,
                      .scene = duet_scene_get_info(scene),
                      .pair = pair,
                      .check.asked = args->check};
    timed_input_named(args->input, &r->input); // which it is: run.c looked
    bool ok = put_in_order(&s, err) && make_world(&s, err) && step(&s, err) && tell(&s, err) &&
              interrupt_check(err);
    timed_free(&r->timed);
    text_free(&r->tuning);
    duet_world_destroy(r->world);
    duet_free(s.ids);
    return ok;
}
