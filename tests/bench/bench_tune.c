// SPDX-License-Identifier: MIT
// How near each strategy comes to the best share on two halves of a CPU, one of
// which counts as slower: its search takes several times what was measured. The strategies'
// choices are then raced against an even grid of shares, all in turn.
#include "bench.h"

#include "support/any_strategy.h"
#include "tuner/race.h"
#include "tuner/subject.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { GRID = 16, ROUNDS = 7 };

static const char *const names[] = {"balance", "fig12", "bisect", "golden", "chunks"};

enum { N_NAMES = sizeof names / sizeof *names };

typedef struct chosen {
    uint32_t share;
    uint32_t launches;
    double ms; // that the search took
} chosen;

static duet_plan plan_at(uint32_t share)
{
    return (duet_plan){
        .share = share, .mode = DUET_MODE_SLAB, .variant_a = "auto", .variant_b = "auto"};
}

static bool measure_share(const measure_machine *machine, uint32_t share, search_sample *sample,
                          duet_error *err)
{
    duet_plan plan = plan_at(share);
    measurement m = measure_plan(machine, &plan, (measure_way){.repeats = 1});
    if (m.failure.status != DUET_STATUS_OK) {
        *err = m.failure;
        return false;
    }
    const profile_sample *at = &m.samples[m.typical];
    *sample = (search_sample){.share = share,
                              .total_ns = (uint64_t)at->total_ns,
                              .a_ns = (uint64_t)at->a_ns,
                              .b_ns = (uint64_t)at->b_ns};
    return true;
}

static bool choose(const measure_machine *machine, const char *name, chosen *out, duet_error *err)
{
    search s;
    search_next next = {0};
    bool ok = any_strategy_begin(&s, name, err);
    *out = (chosen){0};
    while (ok && (ok = search_ask(&s, &next, err)) && !next.done) {
        search_sample sample;
        ok = measure_share(machine, next.at.share, &sample, err) && search_tell(&s, &sample, err);
        out->ms += ok ? (double)sample.total_ns * 1e-6 : 0;
    }
    out->share = ok ? search_pick(&s) : 0;
    out->launches = s.n;
    any_strategy_end(&s);
    return ok;
}

// Rivals: first the chosen shares, then the grid's.
static bool race_all(const measure_machine *machine, const chosen *found, race *r, duet_error *err)
{
    race_options options = {
        .least_rounds = ROUNDS, .most_rounds = ROUNDS, .confidence = 0.99, .dropped = INFINITY};
    *r = race_begin(N_NAMES + GRID + 1, &options);
    uint32_t rival;
    while (race_next(r, &rival)) {
        uint32_t share =
            rival < N_NAMES ? found[rival].share : (rival - N_NAMES) * (DUET_SHARE_ONE / GRID);
        search_sample sample;
        if (!measure_share(machine, share, &sample, err))
            return false;
        race_add(r, rival, (double)sample.total_ns);
    }
    return true;
}

static void print_chosen(uint32_t slower, const chosen *found, const race *r)
{
    uint32_t best = 0;
    for (uint32_t i = 1; i < r->n; ++i)
        best = race_median(r, i) < race_median(r, best) ? i : best;
    for (uint32_t i = 0; i < N_NAMES; ++i)
        printf("| x%-5u | %-8s | %.4f | %8u | %7.0f ms | %8.3f ms | %5.1f %% |\n", slower, names[i],
               found[i].share / (double)DUET_SHARE_ONE, found[i].launches, found[i].ms,
               race_median(r, i) * 1e-6, 100 * (race_median(r, i) / race_median(r, best) - 1));
}

// A machine whose device A searches so many times as slowly as it does.
typedef struct slowed {
    measure_machine real;
    uint32_t slower;
} slowed;

static bool launch_slowed(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                          duet_error *err)
{
    static const char *const searches[] = {"search", "candidates", "narrow"};
    const slowed *s = context;
    if (!s->real.launch(s->real.context, plan, staged, launch, err))
        return false;
    int64_t last = launch->a_ns > launch->b_ns ? launch->a_ns : launch->b_ns;
    launch->a_ns += (int64_t)((s->slower - 1) * measure_stages_ns(launch, 0, searches, 3));
    if (launch->a_ns > last)
        launch->total_ns += launch->a_ns - last;
    return true;
}

static bool compare(const measure_machine *real, uint32_t slower, duet_error *err)
{
    slowed as = {*real, slower};
    const measure_machine slow = {.context = &as, .launch = launch_slowed, .hash = real->hash};
    const measure_machine *machine = &slow;
    chosen found[N_NAMES];
    race r;
    for (uint32_t i = 0; i < N_NAMES; ++i) {
        if (!choose(machine, names[i], &found[i], err))
            return false;
    }
    if (!race_all(machine, found, &r, err))
        return false;
    print_chosen(slower, found, &r);
    return true;
}

static bool run_world(duet_world *world, duet_error *err)
{
    static const uint32_t slower[] = {1, 5, 10};
    subject at = {.kind = &subject_still, .state = world};
    duet_plan whole = plan_at(0);
    duet_result result;
    if (!duet_world_set_plan(world, &whole, err) || !duet_world_step(world, &result, err))
        return false;
    measure_machine machine = subject_machine(&at, duet_result_get_hash(&result));
    printf("| A is   | strategy | share  | launches | searching  | a step      | off     |\n"
           "|--------|----------|--------|----------|------------|-------------|---------|\n");
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof slower / sizeof *slower; ++i)
        ok = compare(&machine, slower[i], err);
    return ok;
}

// The two halves of the first CPU that can be cut.
static duet_device_pair *open_halves(duet_error *err)
{
    duet_device_list *list = duet_device_list_create(err);
    duet_device_pair_def def = duet_default_device_pair_def();
    char halves[2][96] = {"", ""};
    for (uint32_t i = 0; list && i < duet_device_list_get_count(list) && !halves[0][0]; ++i) {
        const duet_device_info *d = duet_device_list_get_info(list, i);
        if (d->kind != DUET_KIND_CPU || !d->can_cut || d->units < 2)
            continue;
        snprintf(halves[0], sizeof halves[0], "%s[0-%u]", d->selector, d->units / 2 - 1);
        snprintf(halves[1], sizeof halves[1], "%s[%u-%u]", d->selector, d->units / 2,
                 d->units / 2 * 2 - 1);
    }
    duet_device_list_destroy(list);
    def.a = halves[0];
    def.b = halves[1];
    if (halves[0][0])
        return duet_device_pair_create(&def, err);
    error_set(err, DUET_STATUS_NO_DEVICE, "there is no CPU that can be cut in two");
    return NULL;
}

bool bench_tune(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 50000;
    duet_device_pair *pair = open_halves(err);
    duet_pose *poses = pair ? paper_poses(n, options->seed) : NULL;
    if (pair && !poses)
        error_set(err, DUET_STATUS_NO_MEMORY, "%u boxes: no memory", n);
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    duet_world *world = poses ? duet_world_create(&def, err) : NULL;
    bool ok = world && duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, err) &&
              run_world(world, err);
    duet_world_destroy(world);
    free(poses);
    duet_device_pair_destroy(pair);
    return ok;
}
