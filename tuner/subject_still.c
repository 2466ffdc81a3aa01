// SPDX-License-Identifier: MIT
// A still step of a scene as a subject: its state is a world with the scene's objects.
#include "tuner/subject.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/sorted_pairs.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

// ---------------------------------------------------------------- def

static void complete(duet_tune_def *def)
{
    const duet_scene_info *scene = duet_scene_get_info(def->scene);
    if (def->n_levels > 0 || def->has_accuracy || !scene->has_accuracy)
        return;
    def->has_accuracy = true;
    def->accuracy = scene->accuracy;
}

// ---------------------------------------------------------------- owner

// The level is settled before anything is measured but levels.
static bool open(subject *s, duet_error *err)
{
    duet_world_def def = duet_scene_world_def(s->def->scene, s->pair);
    if (s->def->n_levels > 0)
        def.level = s->def->levels[0];
    def.has_accuracy = s->def->has_accuracy;
    def.accuracy = s->def->accuracy;
    def.ordered = s->def->ordered;
    duet_world *world = s->state = duet_world_create(&def, err);
    if (!world || !duet_world_set_scene(world, s->def->scene, err))
        return false;
    s->plan = *duet_world_get_plan(world);
    s->units = world->objects.all.n;
    return true;
}

static void close(subject *s)
{
    duet_world_destroy(s->state);
}

static bool describe(subject *s, profile_subject *p, duet_error *err)
{
    return profile_subject_read(s->state, p, err);
}

static bool set_level(subject *s, duet_level level, duet_error *err)
{
    return duet_world_set_level(s->state, level, err);
}

static duet_level level_of(const subject *s)
{
    return duet_world_get_level(s->state);
}

// ---------------------------------------------------------------- truth

// Measures what a level gets wrong, by the pairs that collide.
static bool measure_accuracy(const duet_scene *scene, const duet_pair *pairs, uint64_t n,
                             subject_truth *truth, duet_error *err)
{
    duet_pair *right;
    sorted_pairs_count wrong = {0};
    if (!duet_reference(scene, DUET_LEVEL_CERTIFIED, &right, &truth->pairs, err))
        return false;
    sorted_pairs_compare(pairs, n, right, truth->pairs, sorted_pairs_count_wrong, &wrong);
    duet_free(right);
    double by = fmax((double)truth->pairs, 1);
    truth->accuracy = (duet_accuracy){(double)wrong.missed / by, (double)wrong.added / by};
    return true;
}

// The pairs that every plan must find at the level, and how right they are.
static bool find_truth(subject *s, subject_truth *truth, duet_error *err)
{
    duet_pair *pairs;
    uint64_t n;
    if (!duet_reference(s->def->scene, level_of(s), &pairs, &n, err))
        return false;
    truth->hash = duet_pairs_hash(pairs, n);
    truth->pairs = n; // by certified's promise
    bool ok = level_of(s) == DUET_LEVEL_CERTIFIED ||
              measure_accuracy(s->def->scene, pairs, n, truth, err);
    duet_free(pairs);
    return ok;
}

// ---------------------------------------------------------------- terms

// Which term a stage of a device counts to. A stands where the paper has the CPU
// and B where it has the GPU.
typedef struct row {
    const char *stage;
    size_t at[2]; // A's, B's
} row;

#define AT(term) offsetof(duet_tune_terms, term)

// A's own grid is work that A does before its search, so it is A's time. Only B's pairs cross the
// bus in the paper; if A's do, that ends A's work.
static const row rows[] = {
    {"send objects", {AT(bus2), AT(t1)}},   {"hash", {AT(cpu1), AT(t1)}},
    {"sort", {AT(cpu1), AT(t1)}},           {"bounds", {AT(cpu1), AT(t1)}},
    {"reorder", {AT(cpu1), AT(gpu1)}},      {"cell start", {AT(cpu1), AT(gpu1)}},
    {"clear", {AT(cpu1), AT(gpu2)}},        {"candidates", {AT(cpu1), AT(gpu2)}},
    {"search", {AT(cpu1), AT(gpu2)}},       {"narrow", {AT(cpu2), AT(gpu3)}},
    {"decide", {AT(cpu2), AT(gpu3)}},       {"send grid", {AT(bus1), AT(bus1)}},
    {"receive grid", {AT(bus2), AT(bus2)}}, {"fetch pairs", {AT(cpu2), AT(bus3)}},
};

// Returns what equation 4 leaves over: A's side less B's side, as part of the longer side.
static double imbalance(const duet_tune_terms *t, bool shared)
{
    double a = t->bus1 + t->bus2 + t->cpu1 + t->cpu2;
    double b = t->gpu1 + t->gpu2 + t->gpu3 + t->bus3 + (shared ? 0 : t->t1);
    double longer = fmax(a, b);
    return longer > 0 ? (a - b) / longer : 0;
}

static duet_tune_terms terms_of(const duet_result *result, const duet_plan *plan)
{
    duet_tune_terms terms = {0};
    for (uint32_t i = 0; i < result->n_stages; ++i) {
        const duet_stage *stage = &result->stages[i];
        for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
            if (strcmp(stage->name, rows[k].stage) == 0)
                *(double *)((char *)&terms + rows[k].at[stage->device]) += stage->ms;
        }
    }
    terms.imbalance = imbalance(&terms, plan->mode == DUET_MODE_SHARED);
    return terms;
}

// ---------------------------------------------------------------- launches

// In shared grids A begins once B has built and sent the grid, so its part ends
// that much later; the transfers in between are A's own time.
static double head_start_ms(const duet_result *result, const duet_plan *plan)
{
    static const char *const head[] = {"send objects", "hash",       "sort",     "bounds",
                                       "reorder",      "cell start", "send grid"};
    double ms = 0;
    for (uint32_t i = 0; i < result->n_stages && plan->mode == DUET_MODE_SHARED; ++i) {
        const duet_stage *stage = &result->stages[i];
        for (size_t k = 0; k < sizeof head / sizeof *head && stage->device == 1; ++k)
            ms += strcmp(stage->name, head[k]) == 0 ? stage->ms : 0;
    }
    return ms;
}

search_sample measure_sample(const duet_result *result, const duet_plan *plan)
{
    bool a = plan->share > 0, b = plan->share < DUET_SHARE_ONE;
    return (search_sample){
        .share = plan->share,
        .total_ns = (uint64_t)measure_to_ns(result->total_ms),
        .a_ns = a ? (uint64_t)measure_to_ns(result->device_ms[0] + head_start_ms(result, plan)) : 0,
        .b_ns = b ? (uint64_t)measure_to_ns(result->device_ms[1]) : 0,
    };
}

// Does as an application before each step. Mapped memory keeps what it holds and counts as written.
static bool hand_over_objects(duet_world *world, duet_error *err)
{
    duet_object_kind kind = origin_row_kind(world->def.shape, world->def.origin_edge);
    return duet_world_map_objects(world, kind, world->objects.all.n, err);
}

static bool step(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                 duet_error *err)
{
    const subject *s = context;
    duet_world *world = s->state;
    duet_result result;
    world->def.stage_times = staged;
    if (!duet_world_set_plan(world, plan, err) || !hand_over_objects(world, err))
        return false;
    measure_watch(s->cores, world->def.pair);
    if (!duet_world_step(world, &result, err))
        return false;
    core_use use = core_watch_stop(s->cores);
    search_sample sample = measure_sample(&result, plan);
    *launch = (measure_launch){
        .total_ns = (int64_t)sample.total_ns,
        .a_ns = (int64_t)sample.a_ns,
        .b_ns = (int64_t)sample.b_ns,
        .hash = duet_result_get_hash(&result),
        .use = use,
        .terms = terms_of(&result, plan),
    };
    measure_take_stages(launch, result.stages, result.n_stages);
    return true;
}

static bool read_kernels(void *context, const duet_plan *plan, int side, kernel_spaces *to,
                         duet_error *err)
{
    duet_world *world = ((subject *)context)->state;
    return duet_world_set_plan(world, plan, err) && kernel_spaces_read(world, side, to, err);
}

const subject_kind subject_still = {
    .has = "a still step has",
    .takes = SUBJECT_SCENE | SUBJECT_SEARCH | SUBJECT_VARIANTS | SUBJECT_MODES | SUBJECT_LEVELS |
             SUBJECT_ORDER,
    .complete = complete,
    .open = open,
    .close = close,
    .describe = describe,
    .set_level = set_level,
    .level = level_of,
    .find_truth = find_truth,
    .machine = {.launch = step, .read_kernels = read_kernels},
};
