// SPDX-License-Identifier: MIT
// How near each strategy comes to the best share on two halves of a CPU, one of
// which counts as slower: its search takes several times what was measured. The strategies'
// choices are then raced against an even grid of shares, all in turn.
#include "bench.h"

#include "support/any_strategy.h"
#include "tuner/race.h"
#include "tuner/subject.h"

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

static search_sample measure_share(const measure_machine *machine, uint32_t share)
{
    duet_plan plan = plan_at(share);
    measurement m = measure_plan(machine, &plan, (measure_way){.repeats = 1});
    *ERR = m.failure;
    must(m.failure.status == DUET_STATUS_OK);
    const profile_sample *at = &m.samples[m.typical];
    return (search_sample){.share = share,
                           .total_ns = (uint64_t)at->total_ns,
                           .a_ns = (uint64_t)at->a_ns,
                           .b_ns = (uint64_t)at->b_ns};
}

static chosen choose(const measure_machine *machine, const char *name)
{
    search s;
    search_next next = {0};
    chosen out = {0};
    for (must(any_strategy_begin(&s, name, ERR)); must(search_ask(&s, &next, ERR)) && !next.done;) {
        search_sample sample = measure_share(machine, next.at.share);
        must(search_tell(&s, &sample, ERR));
        out.ms += (double)sample.total_ns * 1e-6;
    }
    out.share = search_pick(&s);
    out.launches = s.n;
    any_strategy_end(&s);
    return out;
}

// Rivals: first the chosen shares, then the grid's.
static race race_all(const measure_machine *machine, const chosen *found)
{
    race_options options = {
        .least_rounds = ROUNDS, .most_rounds = ROUNDS, .confidence = 0.99, .dropped = INFINITY};
    race r = race_begin(N_NAMES + GRID + 1, &options);
    uint32_t rival;
    while (race_next(&r, &rival)) {
        uint32_t share =
            rival < N_NAMES ? found[rival].share : (rival - N_NAMES) * (DUET_SHARE_ONE / GRID);
        race_add(&r, rival, (double)measure_share(machine, share).total_ns);
    }
    return r;
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

static void compare(const measure_machine *real, uint32_t slower)
{
    slowed as = {*real, slower};
    const measure_machine slow = {.context = &as, .launch = launch_slowed, .hash = real->hash};
    chosen found[N_NAMES];
    for (uint32_t i = 0; i < N_NAMES; ++i)
        found[i] = choose(&slow, names[i]);
    race r = race_all(&slow, found);
    print_chosen(slower, found, &r);
}

// On the two halves of the first CPU that can be cut.
void bench_tune(const bench_options *options)
{
    static const uint32_t slower[] = {1, 5, 10};
    uint32_t n = options->n ? options->n : 50000;
    duet_world *world =
        bench_world(must(duet_device_pair_open("halves", ERR)), duet_default_world_def());
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, bench_poses(n, options), n, ERR));
    subject at = {.kind = &subject_still, .state = world};
    duet_plan whole = plan_at(0);
    duet_result result;
    must(duet_world_set_plan(world, &whole, ERR));
    must(duet_world_step(world, &result, ERR));
    measure_machine machine = subject_machine(&at, duet_result_get_hash(&result));
    printf("| A is   | strategy | share  | launches | searching  | a step      | off     |\n"
           "|--------|----------|--------|----------|------------|-------------|---------|\n");
    for (size_t i = 0; i < sizeof slower / sizeof *slower; ++i)
        compare(&machine, slower[i]);
}
