// SPDX-License-Identifier: MIT
#include "cli/inputs.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/text.h"
#include "runtime/broadphase/variant.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/scene/scene.h"
#include "runtime/task/task.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// One device's kernels after the other's. A driver that kept them takes a moment to find
// that out, which is not worth a line.
enum { FOUND_BY_THEN_NS = 1000000000 };

static bool compiled_for_long;

bool inputs_have_compiled(void)
{
    return compiled_for_long;
}

void inputs_show_compiling(void *context, const duet_device_info *device, const char *kernel,
                           uint32_t k, uint32_t n)
{
    static progress shown;
    static char what[160];
    (void)context;
    if (kernel && k == 1) {
        snprintf(what, sizeof what, "%s: first run, compiling kernel", device->selector);
        shown = progress_begin(what, n);
    }
    if (kernel && clock_steady_ns() - shown.begun_ns > FOUND_BY_THEN_NS) {
        compiled_for_long = true;
        progress_show(&shown, k);
    }
    if (!kernel)
        progress_end(&shown);
}

duet_device_pair *inputs_open_pair(const char *selectors, duet_error *err)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = selectors ? selectors : def.a;
    def.on_compile = inputs_show_compiling;
    duet_error why = {0};
    duet_device_pair *pair = duet_device_pair_create(&def, &why);
    if (!pair)
        error_set(err, why.status, "%s%s", !selectors && def.a ? "DUET_PAIR: " : "", why.text);
    if (pair && !duet_device_pair_check_cache(pair, &why))
        fprintf(stderr, "duet: %s; set DUET_CACHE to another folder, or to off\n", why.text);
    return pair;
}

progress inputs_begin_reading(const char *path)
{
    static char what[64];
    snprintf(what, sizeof what, "reading %.50s", strcmp(path, "-") == 0 ? "stdin" : path);
    return progress_begin(what, 0);
}

void inputs_make_settings(scene_settings *s, const scene_options *options)
{
    *s = (scene_settings){.n = options->settings.n};
    for (uint32_t i = 0; i < s->n; ++i) {
        const option_setting *given = &options->settings.items[i];
        s->list[i] = (duet_setting){given->name, given->value};
    }
    if (options->n != UINT64_MAX) {
        snprintf(s->objects, sizeof s->objects, "%" PRIu64, options->n);
        s->list[s->n++] = (duet_setting){"n", s->objects};
    }
    if (options->seed != UINT64_MAX) {
        snprintf(s->seed, sizeof s->seed, "%" PRIu64, options->seed);
        s->list[s->n++] = (duet_setting){"seed", s->seed};
    }
}

void inputs_tell_empty(const duet_scene_info *info)
{
    if (info->n == 0)
        say_note("%s: there are no objects", info->name);
}

static duet_scene *load_with(const char *path, const scene_options *options, duet_error *err)
{
    scene_settings settings;
    inputs_make_settings(&settings, options);
    progress p = inputs_begin_reading(path);
    progress_follow(&p);
    duet_scene *scene = duet_scene_load(path, settings.list, settings.n, err);
    progress_end(&p);
    return scene;
}

task *inputs_load_task(const char *path, const scene_options *options, duet_error *err)
{
    scene_settings settings;
    inputs_make_settings(&settings, options);
    progress p = progress_begin("loading the task and its reference", 0);
    progress_show(&p, 0);
    task *t = task_load(path, settings.list, settings.n, err);
    progress_end(&p);
    return t;
}

duet_scene *inputs_load_scene(const char *path, const scene_options *options, duet_error *err)
{
    duet_scene *scene = load_with(path, options, err);
    if (scene)
        inputs_tell_empty(duet_scene_get_info(scene));
    return scene;
}

duet_scene *inputs_load_objects(const char *path, const scene_options *options, duet_error *err)
{
    duet_scene *scene = load_with(path, options, err);
    const duet_scene_info *info = scene ? duet_scene_get_info(scene) : NULL;
    if (!info || info->n > 0)
        return scene;
    bad_argument(err, "%s: there are no objects to measure", info->name);
    duet_scene_destroy(scene);
    return NULL;
}

bool inputs_put_in_order(duet_scene *scene, duet_device_pair *pair, uint32_t **ids, duet_error *err)
{
    uint32_t n = 0;
    duet_world_def def = duet_scene_world_def(scene, pair);
    duet_world *world = duet_world_create(&def, err);
    bool ok = world && duet_world_set_scene(world, scene, err) &&
              duet_world_order(world, ids, &n, err) && scene_reorder(scene, *ids, err);
    duet_world_destroy(world);
    return ok;
}

duet_scene *inputs_load_pairs(const char *path, duet_error *err)
{
    progress p = inputs_begin_reading(path);
    progress_follow(&p);
    duet_scene *pairs = duet_scene_load_pairs(path, err);
    progress_end(&p);
    if (pairs && duet_scene_get_info(pairs)->n == 0)
        say_note("%s: there are no pairs", duet_scene_get_info(pairs)->name);
    return pairs;
}

bool inputs_find_reference(const duet_scene *scene, duet_level level, duet_pair **pairs,
                           uint64_t *n, duet_error *err)
{
    progress p = progress_begin("reference", 0);
    progress_follow(&p);
    bool ok = duet_reference(scene, level, pairs, n, err);
    progress_end(&p);
    return ok;
}

// Refuses a name, and lists those there are.
static bool refuse_name(const char *prefix, const char *given_by, const char *name,
                        const char *what, const char *(*name_of)(int i), duet_error *err)
{
    text known = {0};
    for (int i = 0; name_of(i); ++i)
        text_add(&known, "%s%s", i ? ", " : "", name_of(i));
    bad_argument(err, "--%s%s '%s': the %s are %s", prefix, given_by, name, what,
                 text_chars(&known));
    text_free(&known);
    return false;
}

static bool change_mode(const plan_options *options, duet_mode *mode, duet_error *err)
{
    return !options->mode || mode_from_name(options->mode, mode) ||
           refuse_name(options->prefix, "mode", options->mode, "modes", mode_name, err);
}

bool inputs_read_level(const char *name, duet_level *level, duet_error *err)
{
    *level = DUET_LEVEL_CERTIFIED;
    return !name || duet_level_from_name(name, level) ||
           refuse_name("", "level", name, "levels", level_name, err);
}

bool inputs_accuracy_given(const level_options *options, duet_accuracy *accuracy)
{
    *accuracy = (duet_accuracy){fmax(options->missed, 0), fmax(options->false_rate, 0)};
    return options->missed >= 0 || options->false_rate >= 0;
}

bool inputs_change_level(const level_options *options, duet_world_def *def, duet_error *err)
{
    duet_accuracy accuracy;
    bool given = inputs_accuracy_given(options, &accuracy);
    if (given && options->level)
        return bad_argument(
            err, "--level %s: give a level, or --missed and --false-rate that one is chosen by",
            options->level);
    if (given) {
        def->has_accuracy = true;
        def->accuracy = accuracy;
    }
    if (!options->level)
        return true;
    def->has_accuracy = false;
    return inputs_read_level(options->level, &def->level, err);
}

// Its first word; what follows is read where the kernels are known. NULL: the pair is not known
// yet.
static bool check_variant(const char *name, const duet_device_pair *pair, duet_error *err)
{
    char word[DUET_VARIANT];
    variant v;
    if (strlen(name) >= DUET_VARIANT)
        return bad_argument(err, "a variant of %zu characters: %d are the most", strlen(name),
                            DUET_VARIANT - 1);
    name += strspn(name, " ,");
    snprintf(word, sizeof word, "%.*s", (int)strcspn(name, " ,"), name);
    return !pair || !*word || variant_parse(&v, word, duet_device_pair_get_info(pair, 1), err);
}

static bool change_variants(const plan_options *options, const duet_device_pair *pair,
                            duet_plan *plan, duet_error *err)
{
    const struct {
        const char *option, *name;
        char *to[2];
    } given[] = {{"variant", options->variant, {plan->variant_a, plan->variant_b}},
                 {"variant-a", options->variants[0], {plan->variant_a}},
                 {"variant-b", options->variants[1], {plan->variant_b}}};
    for (size_t i = 0; i < sizeof given / sizeof *given; ++i) {
        duet_error why = {0};
        if (!given[i].name)
            continue;
        if (!check_variant(given[i].name, pair, &why))
            return error_set(err, why.status, "--%s%s: %s", options->prefix, given[i].option,
                             why.text);
        for (int k = 0; k < 2 && given[i].to[k]; ++k)
            strcpy(given[i].to[k], given[i].name);
    }
    return true;
}

bool inputs_plan_given(const plan_options *options)
{
    return options->share != UINT32_MAX || options->mode || options->variant ||
           options->variants[0] || options->variants[1];
}

// Whoever names a device twice, or halves of one that has a single unit, means to share.
static bool is_one_chosen(const duet_device_pair *pair, const char *selectors)
{
    const char *chosen = selectors ? selectors : duet_default_device_pair_def().a;
    return duet_device_pair_is_one(pair) &&
           (!chosen || (!strchr(chosen, ',') && strcmp(chosen, "halves") != 0));
}

static bool refuse_on_one(const char *prefix, const char *name, const duet_device_pair *pair,
                          duet_error *err)
{
    return bad_argument(err, "--%s%s: %s is one device; expected --%spair with two, or halves",
                        prefix, name, duet_device_pair_get_info(pair, 0)->selector, prefix);
}

// A mode goes with a share that is given, as 'duet tune' prints plans, also where that is 0.
static bool check_plan(const plan_options *options, const duet_device_pair *pair,
                       const char *selectors, duet_error *err)
{
    bool is_given = options->share != UINT32_MAX;
    bool shares = is_given && options->share > 0 && options->share < DUET_SHARE_ONE;
    if ((!shares && (is_given || !options->mode)) || !is_one_chosen(pair, selectors))
        return true;
    return refuse_on_one(options->prefix, shares ? "share" : "mode", pair, err);
}

bool inputs_change_plan(const plan_options *options, const duet_device_pair *pair,
                        const char *selectors, duet_plan *plan, duet_error *err)
{
    if (options->share != UINT32_MAX)
        plan->share = options->share;
    return change_mode(options, &plan->mode, err) && change_variants(options, pair, plan, err) &&
           check_plan(options, pair, selectors, err);
}

bool inputs_do_without_profile(const duet_error *why, duet_error *err)
{
    if (why->status == DUET_STATUS_DEVICE_FAILED || why->status == DUET_STATUS_NO_MEMORY)
        return error_copy(err, why);
    say_failed(why);
    return true;
}

// ---------------------------------------------------------------- motions

// A motion in which nothing happens has no plan.
static bool happens(const duet_motion *motion)
{
    return duet_motion_get_count(motion) > 0 && duet_motion_get_effects(motion) != 0;
}

duet_motion *inputs_make_motion(const duet_scene *scene, duet_motion_def *def,
                                const char *selectors, const plan_options *options,
                                duet_profile *profile, duet_error *err)
{
    duet_error failure = {0};
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    if (!inputs_change_plan(options, def->pair, selectors, &def->plan, err))
        return NULL;
    duet_motion *motion = duet_motion_create_from_scene(def, scene, NULL, err);
    if (!motion || !happens(motion) || inputs_plan_given(options) ||
        duet_motion_load_profile(motion, NULL, profile, &failure) ||
        inputs_do_without_profile(&failure, err))
        return motion;
    duet_motion_destroy(motion);
    return NULL;
}

duet_plan inputs_motion_plan(const duet_motion *motion)
{
    const duet_plan *of_pairs = duet_motion_get_plan(motion);
    if (of_pairs)
        return *of_pairs;
    duet_plan plan = duet_default_plan(duet_motion_get_def(motion)->pair);
    plan.share = 0;
    return plan;
}

bool inputs_check_recorded(const duet_replay *replay, const char *path, uint64_t steps,
                           duet_error *err)
{
    const uint64_t recorded = duet_replay_get_info(replay).steps;
    return steps <= recorded ||
           bad_argument(err, "--steps %" PRIu64 ": %s has %" PRIu64 " recorded steps", steps, path,
                        recorded);
}
