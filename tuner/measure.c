// SPDX-License-Identifier: MIT
#include "tuner/measure.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "tuner/stats.h"
#include "tuner/terms.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

int64_t measure_to_ns(double ms)
{
    return (int64_t)(ms * 1e6 + 0.5);
}

void measure_watch(core_watch *cores, const duet_device_pair *pair)
{
    uint32_t units = 0, most = 1;
    for (int device = duet_device_pair_is_one(pair) ? 1 : 0; device < 2; ++device) {
        const duet_device_info *info = duet_device_pair_get_info(pair, device);
        uint32_t own = info->kind == DUET_KIND_CPU ? info->units : 0;
        units += own;
        most = own > most ? own : most;
    }
    core_watch_start(cores, most > 1 ? units : 1);
}

void measure_take_stages(measure_launch *launch, const duet_stage *stages, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i)
        launch->transfer_ns += stages[i].transfer ? measure_to_ns(stages[i].ms) : 0;
    launch->n_stages = n < MEASURE_STAGES ? n : MEASURE_STAGES;
    memcpy(launch->stages, stages, launch->n_stages * sizeof *stages);
}

uint32_t measure_find_stage(const duet_stage *stages, uint32_t n, const duet_stage *like)
{
    uint32_t at = 0;
    while (at < n &&
           (stages[at].device != like->device || strcmp(stages[at].name, like->name) != 0))
        ++at;
    return at;
}

uint64_t measure_stages_ns(const measure_launch *launch, int side, const char *const *names,
                           uint32_t most)
{
    int64_t ns = 0;
    for (uint32_t i = 0; i < launch->n_stages; ++i) {
        const duet_stage *stage = &launch->stages[i];
        for (uint32_t k = 0; k < most && names[k]; ++k)
            if (stage->device == side && strcmp(stage->name, names[k]) == 0)
                ns += measure_to_ns(stage->ms);
    }
    return (uint64_t)ns;
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
                         "result hash %016" PRIx64 " instead of %016" PRIx64, launch->hash,
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

// A disturbance only ever adds to a kernel's time, which the device's own clock took:
// what warmed up counts too.
static void take_least_stages(measure_launch *launch, const measure_launch *launches, uint32_t n)
{
    for (uint32_t i = 0; i < launch->n_stages; ++i) {
        duet_stage *stage = &launch->stages[i];
        for (uint32_t k = 0; k < n; ++k) {
            // Launches differ in their stages: some have nothing to clear.
            uint32_t at = measure_find_stage(launches[k].stages, launches[k].n_stages, stage);
            if (at < launches[k].n_stages)
                stage->ms = fmin(stage->ms, launches[k].stages[at].ms);
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

// The first of the counted samples with the greatest total up to the median.
static uint32_t find_typical(const profile_sample *samples, uint32_t n, double median_ns)
{
    uint32_t typical = n;
    for (uint32_t i = 0; i < n; ++i)
        if (counts(&samples[i]) && (double)samples[i].total_ns <= median_ns &&
            (typical == n || samples[i].total_ns > samples[typical].total_ns))
            typical = i;
    return typical;
}

// Statistics over all counted launches; outliers are marked and stay in.
static void summarize(measurement *m, const measure_launch *launches)
{
    double totals[MEASURE_LAUNCHES];
    uint32_t samples[MEASURE_LAUNCHES];
    bool marks[MEASURE_LAUNCHES];
    uint32_t n = list_counted(m, totals, samples);
    m->row.outliers = stats_mark_outliers(totals, n, marks);
    m->row.median_ns = stats_median(totals, n);
    m->row.mad_ns = stats_mad(totals, n);
    stats_interval in = stats_median_interval(totals, n, 0.95);
    m->row.low_ns = in.low;
    m->row.high_ns = in.high;
    for (uint32_t i = 0; i < n; ++i)
        if (marks[i])
            m->samples[samples[i]].flags |= PROFILE_SAMPLE_OUTLIER;
    m->typical = find_typical(m->samples, m->n_samples, m->row.median_ns);
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
    m->trial.watched += !warms_up && launches[at].use.cpu_ns > 0;
    m->trial.disturbed += disturbed;
    m->repeated += disturbed && way.quiet;
    m->counted += counts(sample);
    ++m->n_samples;
    return true;
}

static bool train(const measure_machine *machine, const duet_plan *plan, uint32_t n,
                  duet_error *err)
{
    if (machine->train)
        return machine->train(machine->context, plan, n, err);
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i) {
        measure_launch launch = {0};
        ok =
            budget_check_stop(NULL) && machine->launch(machine->context, plan, false, &launch, err);
    }
    return ok;
}

// Launches until the counter moves; adds to n how often.
static bool train_until_move(const measure_machine *machine, const duet_plan *plan,
                             energy_meter *meter, uint32_t batch, uint32_t most, uint32_t *n,
                             duet_error *err)
{
    uint32_t from = *n;
    double before = energy_meter_slowest(meter);
    do {
        if (!train(machine, plan, batch, err))
            return false;
        *n += batch;
        if (energy_meter_slowest(meter) != before)
            return true;
    } while (*n - from < most);
    return error_set(err, DUET_STATUS_NOT_FOUND, "energy: %s did not move within %u launch%s",
                     energy_meter_describe(meter), *n - from, *n - from == 1 ? "" : "es");
}

// Counters move in steps, as seldom as every 100 ms: from one move to a later one is known how many
// launches took what was counted, however long the step. What the first batch ran into is left out.
static bool measure_energy(measurement *m, const measure_machine *machine, const duet_plan *plan,
                           energy_meter *meter)
{
    enum { MOVES = 4, BATCHES = 64, MOST = 1000000 };
    static const double longest_ns = 2e9; // that a counter may stand
    double launch_ns = fmax(m->row.median_ns, 1), window_ns = (double)energy_meter_window_ns(meter);
    uint32_t batch = (uint32_t)fmin(fmax(ceil(window_ns / BATCHES / launch_ns), 1), MOST);
    uint32_t most = (uint32_t)fmin(fmax(longest_ns / launch_ns, 1), MOST), n = 0;
    bool ok = train_until_move(machine, plan, meter, batch, most, &n, &m->failure);
    double before = energy_meter_read(meter);
    n = 0;
    for (int moves = 0; ok && (moves < MOVES || n * launch_ns < window_ns); ++moves)
        ok = train_until_move(machine, plan, meter, batch, most, &n, &m->failure);
    m->launch.terms.joules = ok ? (energy_meter_read(meter) - before) / n : 0;
    return ok;
}

measurement measure_plan(const measure_machine *machine, const duet_plan *plan, measure_way way)
{
    assert(way.repeats > 0 && way.repeats <= MEASURE_REPEATS);
    measurement m = {.trial = {.plan = *plan, .sample.share = plan->share}};
    measure_launch launches[MEASURE_LAUNCHES];
    duet_error *err = &m.failure;
    uint64_t begun = clock_steady_ns();
    bool ok = true;
    while (ok && !is_finished(&m, way))
        ok = add_launch(&m, machine, plan, way, launches);
    // Ctrl-C reaches a driver's compiler as well, whose complaint is none of the plan's.
    if (!ok && !budget_check_stop(NULL))
        *err = (duet_error){.status = DUET_STATUS_INTERRUPTED, .text = "stopped"};
    if (err->status == DUET_STATUS_OK && m.counted > 0)
        summarize(&m, launches);
    if (way.meter && err->status == DUET_STATUS_OK && m.counted == way.repeats)
        measure_energy(&m, machine, plan, way.meter);
    m.row.outcome = outcome_of(err);
    m.trial.launches = m.n_samples;
    m.trial.spent_ns = clock_steady_ns() - begun;
    m.trial.usable = err->status == DUET_STATUS_OK;
    if (m.trial.usable) {
        m.trial.sample.total_ns = (uint64_t)m.launch.total_ns;
        m.trial.sample.a_ns = (uint64_t)m.launch.a_ns;
        m.trial.sample.b_ns = (uint64_t)m.launch.b_ns;
        m.trial.terms = m.launch.terms;
    }
    return m;
}

trial measure_recall(const duet_plan *plan, const profile_trial *row)
{
    trial t = {.plan = *plan,
               .scope = (int32_t)row->scope,
               .usable = strcmp(row->outcome, "ok") == 0,
               .sample.share = plan->share,
               .focus_ns = row->focus_ns,
               .launches = row->n_samples,
               .disturbed = row->disturbed,
               .spent_ns = row->spent_ns};
    for (uint32_t i = 0; i < row->n_samples; ++i) {
        const profile_sample *sample = &row->samples[i];
        t.watched += !(sample->flags & PROFILE_SAMPLE_WARM_UP) && sample->cpu_ns > 0;
        t.disturbed += (sample->flags & PROFILE_SAMPLE_DISTURBED) != 0;
    }
    uint32_t typical = find_typical(row->samples, row->n_samples, row->median_ns);
    if (t.usable && typical < row->n_samples) {
        t.sample.total_ns = (uint64_t)row->samples[typical].total_ns;
        t.sample.a_ns = (uint64_t)row->samples[typical].a_ns;
        t.sample.b_ns = (uint64_t)row->samples[typical].b_ns;
        terms_from_json(row->terms, &t.terms);
    }
    return t;
}
