// SPDX-License-Identifier: MIT
#include "tuner/measure.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "tuner/stats.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

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

const terms_field terms_fields[] = {
    {"T_1", AT(t1)},
    {"T_CPU1", AT(cpu1)},
    {"T_CPU2", AT(cpu2)},
    {"T_GPU1", AT(gpu1)},
    {"T_GPU2", AT(gpu2)},
    {"T_GPU3", AT(gpu3)},
    {"T_BUS1", AT(bus1)},
    {"T_BUS2", AT(bus2)},
    {"T_BUS3", AT(bus3)},
    {"imbalance", AT(imbalance)},
    {NULL, 0},
};

static double *value_of(const terms_field *f, duet_tune_terms *terms)
{
    return (double *)((char *)terms + f->at);
}

double terms_value(const terms_field *f, const duet_tune_terms *terms)
{
    return *(const double *)((const char *)terms + f->at);
}

void terms_to_json(const duet_tune_terms *terms, text *json)
{
    for (const terms_field *f = terms_fields; f->name; ++f)
        text_add(json, "%c\"%s\":%.6f", f == terms_fields ? '{' : ',', f->name,
                 terms_value(f, terms));
    text_add(json, "}");
}

void terms_from_json(const cJSON *json, duet_tune_terms *terms)
{
    *terms = (duet_tune_terms){0};
    for (const terms_field *f = terms_fields; f->name; ++f) {
        const cJSON *number = cJSON_GetObjectItemCaseSensitive(json, f->name);
        *value_of(f, terms) = cJSON_IsNumber(number) ? number->valuedouble : 0;
    }
}

// ---------------------------------------------------------------- launches

static int64_t to_ns(double ms)
{
    return (int64_t)(ms * 1e6 + 0.5);
}

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
        .total_ns = (uint64_t)to_ns(result->total_ms),
        .a_ns = a ? (uint64_t)to_ns(result->device_ms[0] + head_start_ms(result, plan)) : 0,
        .b_ns = b ? (uint64_t)to_ns(result->device_ms[1]) : 0,
    };
}

// Mapped memory keeps what it holds and counts as written.
static bool hand_over_objects(const measure_world *at, duet_error *err)
{
    return duet_world_map_objects(at->world, at->kind, at->n, err);
}

static bool step_world(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                       duet_error *err)
{
    const measure_world *at = context;
    duet_result result;
    at->world->def.stage_times = staged;
    if (!duet_world_set_plan(at->world, plan, err) || !hand_over_objects(at, err))
        return false;
    core_watch_start(at->cores);
    if (!duet_world_step(at->world, &result, err))
        return false;
    core_use use = core_watch_stop(at->cores);
    search_sample sample = measure_sample(&result, plan);
    *launch = (measure_launch){
        .total_ns = (int64_t)sample.total_ns,
        .a_ns = (int64_t)sample.a_ns,
        .b_ns = (int64_t)sample.b_ns,
        .hash = duet_result_get_hash(&result),
        .use = use,
        .terms = terms_of(&result, plan),
    };
    for (uint32_t i = 0; i < result.n_stages; ++i)
        launch->transfer_ns += result.stages[i].transfer ? to_ns(result.stages[i].ms) : 0;
    launch->n_stages = result.n_stages < MEASURE_STAGES ? result.n_stages : MEASURE_STAGES;
    memcpy(launch->stages, result.stages, launch->n_stages * sizeof *launch->stages);
    return true;
}

uint64_t measure_stages_ns(const measure_launch *launch, int side, const char *const *names,
                           uint32_t most)
{
    int64_t ns = 0;
    for (uint32_t i = 0; i < launch->n_stages; ++i) {
        const duet_stage *stage = &launch->stages[i];
        for (uint32_t k = 0; k < most && names[k]; ++k)
            if (stage->device == side && strcmp(stage->name, names[k]) == 0)
                ns += to_ns(stage->ms);
    }
    return (uint64_t)ns;
}

measure_machine measure_world_machine(measure_world *world, uint64_t hash)
{
    return (measure_machine){.context = world, .launch = step_world, .hash = hash};
}

static const char *outcome_of(const duet_error *err)
{
    switch (err->status) {
    case DUET_STATUS_OK:
        return "ok";
    case DUET_STATUS_BUILD_FAILED:
        return "build";
    case DUET_STATUS_WRONG_RESULT:
        return "wrong";
    default:
        return "launch";
    }
}

static bool launch_once(const measure_machine *machine, const duet_plan *plan, bool staged,
                        uint32_t flags, measure_launch *launch, profile_sample *sample,
                        duet_error *err)
{
    *launch = (measure_launch){0};
    if (!budget_check_stop(NULL) || !machine->launch(machine->context, plan, staged, launch, err))
        return false;
    if (launch->hash != machine->hash)
        return error_set(err, DUET_STATUS_WRONG_RESULT,
                         "pair hash %016" PRIx64 " instead of %016" PRIx64, launch->hash,
                         machine->hash);
    *sample = (profile_sample){
        .total_ns = launch->total_ns,
        .a_ns = launch->a_ns,
        .b_ns = launch->b_ns,
        .transfer_ns = launch->transfer_ns,
        .cpu_ns = (int64_t)launch->use.cpu_ns,
        .wait_ns = (int64_t)launch->use.wait_ns,
        .flags = flags,
        .at_ns = clock_calendar_ns(),
    };
    return true;
}

// Launches differ in their stages: some have nothing to clear.
static const duet_stage *find_stage(const measure_launch *launch, const duet_stage *like)
{
    for (uint32_t i = 0; i < launch->n_stages; ++i) {
        const duet_stage *stage = &launch->stages[i];
        if (stage->device == like->device && strcmp(stage->name, like->name) == 0)
            return stage;
    }
    return NULL;
}

// A disturbance only ever adds to a kernel's time, which the device's own clock took:
// what warmed up counts too.
static void take_least_stages(measure_launch *launch, const measure_launch *launches, uint32_t n)
{
    for (uint32_t i = 0; i < launch->n_stages; ++i) {
        duet_stage *stage = &launch->stages[i];
        for (uint32_t k = 0; k < n; ++k) {
            const duet_stage *other = find_stage(&launches[k], stage);
            stage->ms = other ? fmin(stage->ms, other->ms) : stage->ms;
        }
    }
}

static bool counts(const profile_sample *sample)
{
    return !(sample->flags & (PROFILE_SAMPLE_WARM_UP | PROFILE_SAMPLE_DISTURBED));
}

// The times of the launches that count, and which samples they are.
static uint32_t list_counted(const measurement *m, double *totals, uint32_t *samples)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < m->n_samples; ++i) {
        if (!counts(&m->samples[i]))
            continue;
        totals[n] = (double)m->samples[i].total_ns;
        samples[n++] = i;
    }
    return n;
}

// Statistics over all counted launches; outliers are marked and stay in.
static void summarize(measurement *m, const measure_launch *launches)
{
    double totals[MEASURE_LAUNCHES];
    uint32_t samples[MEASURE_LAUNCHES];
    bool marks[MEASURE_LAUNCHES];
    uint32_t n = list_counted(m, totals, samples);
    m->outliers = stats_mark_outliers(totals, n, marks);
    m->median_ns = stats_median(totals, n);
    m->mad_ns = stats_mad(totals, n);
    stats_interval in = stats_median_interval(totals, n, 0.95);
    m->low_ns = in.low;
    m->high_ns = in.high;
    uint32_t typical = 0;
    for (uint32_t i = 0; i < n; ++i) {
        if (marks[i])
            m->samples[samples[i]].flags |= PROFILE_SAMPLE_OUTLIER;
        bool nearer = totals[i] <= m->median_ns && totals[i] > totals[typical];
        if (nearer || totals[typical] > m->median_ns)
            typical = i;
    }
    m->typical = samples[typical];
    m->launch = launches[m->typical];
    take_least_stages(&m->launch, launches, m->n_samples);
}

static bool is_finished(const measurement *m, measure_way way)
{
    uint32_t warm_ups = way.warm ? 0 : 1;
    return m->counted == way.repeats || m->n_samples == warm_ups + 2 * way.repeats + 4;
}

// Adds a launch and its sample.
static bool add_launch(measurement *m, const measure_machine *machine, const duet_plan *plan,
                       measure_way way, measure_launch *launches)
{
    uint32_t at = m->n_samples;
    bool warms_up = at == 0 && !way.warm;
    profile_sample *sample = &m->samples[at];
    if (!launch_once(machine, plan, way.staged || warms_up, warms_up ? PROFILE_SAMPLE_WARM_UP : 0,
                     &launches[at], sample, &m->failure))
        return false;
    bool disturbed = !warms_up && launches[at].use.disturbed;
    if (disturbed && way.quiet)
        sample->flags |= PROFILE_SAMPLE_DISTURBED;
    m->watched += !warms_up && launches[at].use.cpu_ns > 0;
    m->disturbed += disturbed;
    m->repeated += disturbed && way.quiet;
    m->counted += counts(sample);
    ++m->n_samples;
    return true;
}

measurement measure_plan(const measure_machine *machine, const duet_plan *plan, measure_way way)
{
    assert(way.repeats > 0 && way.repeats <= MEASURE_REPEATS && (way.staged || !way.warm));
    measurement m = {0};
    measure_launch launches[MEASURE_LAUNCHES];
    duet_error *err = &m.failure;
    uint64_t begun = clock_steady_ns();
    bool ok = true;
    while (ok && !is_finished(&m, way))
        ok = add_launch(&m, machine, plan, way, launches);
    // Ctrl-C reaches a driver's compiler as well, whose complaint is none of the plan's.
    if (!ok && !budget_check_stop(NULL))
        *err = (duet_error){.status = DUET_STATUS_INTERRUPTED, .text = "stopped"};
    m.spent_ns = clock_steady_ns() - begun;
    m.outcome = outcome_of(err);
    if (err->status == DUET_STATUS_OK && m.counted > 0)
        summarize(&m, launches);
    return m;
}
