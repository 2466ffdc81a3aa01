// SPDX-License-Identifier: MIT
// The six example tasks: what each strategy finds of kernels and share, beside every plan of an
// even grid. Brute force's plan, its best shared plan and the next best of its launches race in
// turn, --runs rounds; the best of them is what the others are compared with. The least of several
// medians is a lucky one, so it races anew, with what each strategy found, each device alone by the
// kernels that the default strategy found, and itself under another name, which shows what noise
// is. That race goes on until each strategy's median ratio is known within 3 %, or for
// FINAL_SECONDS. A launch's time is without what other programs took of it. --n: items of saxpy;
// the others have as much less work. --task: one, of --n items.
//
// Brute force counts a plan, but does not launch it, if one part of it alone took 1.3 times as long
// as the quickest plan. Every strategy tells how far it is, and the bench fails if brute force
// takes longer than --seconds.
#include "bench.h"

#include "runtime/task/task.h"
#include "tuner/stats.h"
#include "tuner/subject.h"
#include "tuner/tune.h"

static const struct {
    const char *name;
    double n;
    double power; // of n, by which the work grows
} tasks[] = {{"saxpy", 1e6, 1},   {"nbody", 4096, 2}, {"histogram", 4e6, 1},
             {"stencil", 512, 2}, {"matmul", 256, 3}, {"black_scholes", 2e5, 1}};

// The first is what the others are compared with, and the second the default. --strategy: these two
// and that one.
static const char *const names[] = {"brute", "balance", "annealing", "random"};

enum {
    N_NAMES = sizeof names / sizeof *names,
    AGAIN = N_NAMES, // brute force's plan
    A_ALONE,
    B_ALONE,
    RIVALS,
    HEAT = 6, // brute force's plan, its best shared one, and the next best
    TELL_SECONDS = 5,
    FINAL_SECONDS = 8,
    TASKS = sizeof tasks / sizeof *tasks
};

typedef struct rival {
    const char *name;
    duet_plan plan;
    duet_tune_outcome found; // of a strategy
    double ms[STATS_MOST];
} rival;

// Leaves what other programs took of a launch out of it, which is of the device that took longer.
static void leave_out_lost(measure_launch *launch)
{
    int64_t lost = (int64_t)launch->use.lost_ns;
    int64_t *longer = launch->a_ns > launch->b_ns ? &launch->a_ns : &launch->b_ns;
    *longer = *longer > lost + 1000 ? *longer - lost : 1000;
    launch->total_ns = launch->total_ns - lost > *longer ? launch->total_ns - lost : *longer;
    launch->use = (core_use){0};
}

// ---------------------------------------------------------------- parts

// Times that each device took for its part of plans, so that brute force need not launch a plan of
// which one part alone was seen to take too long.
enum { PART_TIMES = 1024 }; // of a device

// The least of a part's launches, at a share by a kernel, without what other programs took of them.
typedef struct part_time {
    uint32_t share;
    char variant[DUET_VARIANT];
    int64_t ns;
} part_time;

typedef struct part_times {
    part_time of[2][PART_TIMES];
    uint32_t n[2];
    int64_t least_ns; // a launch's, of any plan, with what other programs took of it
    uint32_t passed_over;
} part_times;

// Returns the place of the plan's part, or of a new one; PART_TIMES if there is no space.
static uint32_t find_part(const part_times *p, const duet_plan *plan, int device)
{
    uint32_t i = 0;
    while (i < p->n[device] && (p->of[device][i].share != plan->share ||
                                strcmp(p->of[device][i].variant, plan_variant(plan, device)) != 0))
        ++i;
    return i;
}

// Whether the plan may be the quickest: it shares nothing, or no part of it took 1.3 times as long
// as the quickest plan, by the same kernel at the same share. Counts those that may not.
static bool part_times_allow(part_times *p, const duet_plan *plan)
{
    bool shares = plan->share > 0 && plan->share < DUET_SHARE_ONE, slow = false;
    for (int device = 0; device < 2 && shares; ++device) {
        uint32_t i = find_part(p, plan, device);
        slow |= i < p->n[device] && p->of[device][i].ns * 10 > p->least_ns * 13;
    }
    p->passed_over += slow;
    return !slow;
}

static void part_times_add(part_times *p, const duet_plan *plan, const measure_launch *launch)
{
    const int64_t lost = (int64_t)launch->use.lost_ns;
    const int64_t ns[2] = {launch->a_ns - lost, launch->b_ns - lost};
    if (p->least_ns == 0 || launch->total_ns < p->least_ns)
        p->least_ns = launch->total_ns;
    for (int device = 0; device < 2; ++device) {
        uint32_t i = find_part(p, plan, device);
        if (i == PART_TIMES)
            continue;
        part_time *at = &p->of[device][i];
        if (i == p->n[device]) {
            *at = (part_time){.share = plan->share, .ns = ns[device]};
            snprintf(at->variant, sizeof at->variant, "%s", plan_variant(plan, device));
            ++p->n[device];
        }
        at->ns = ns[device] < at->ns ? ns[device] : at->ns;
    }
}

// ---------------------------------------------------------------- strategies

// A strategy at work.
typedef struct worker {
    subject *subject;
    const char *task, *strategy;
    part_times *parts;   // NULL: each plan is launched
    double most_seconds; // 0: it may take any time
    double told_seconds;
    double left_seconds;
} worker;

static bool launch_allowed(void *context, const duet_plan *plan, bool staged,
                           measure_launch *launch, duet_error *err)
{
    worker *w = context;
    if (w->parts && !part_times_allow(w->parts, plan))
        return error_set(err, DUET_STATUS_NOT_FOUND, "one part alone takes too long");
    if (!w->subject->kind->machine.launch(w->subject, plan, staged, launch, err))
        return false;
    if (w->parts)
        part_times_add(w->parts, plan, launch);
    leave_out_lost(launch);
    return true;
}

static bool read_kernels(void *context, const duet_plan *plan, int side, kernel_spaces *to,
                         duet_error *err)
{
    subject *s = ((worker *)context)->subject;
    return s->kind->machine.read_kernels(s, plan, side, to, err);
}

static bool is_late(const worker *w, double seconds)
{
    return w->most_seconds > 0 && seconds > w->most_seconds;
}

// Tells how far it is; false once it has taken too long.
static bool watch(void *context, const duet_tune_progress *p)
{
    worker *w = context;
    w->left_seconds = fmax(0, p->seconds * (p->most_trials / (double)p->trials - 1));
    if (p->seconds > w->told_seconds + TELL_SECONDS) {
        fprintf(stderr, "%s, %s: %u of at most %u trials in %.0f s, about %.0f s more\n", w->task,
                w->strategy, p->trials, p->most_trials, p->seconds, w->left_seconds);
        w->told_seconds = p->seconds;
    }
    return !is_late(w, p->seconds);
}

// As duet_tune_run does, of such launches.
static void find_plan(worker *w, rival *r, trial_log *log)
{
    subject *s = w->subject;
    const duet_plan usual = duet_default_plan(s->pair);
    const tune_problem problem = {
        .def = s->def,
        .machine = {.context = w, .launch = launch_allowed, .read_kernels = read_kernels},
        .one_device = s->one_device,
        .plan = s->plan,
        .start = usual.share,
        .fair = usual.share,
        .fair_mode = usual.mode,
        .least_share = tune_least_share(s->units),
    };
    uint64_t begun = clock_steady_ns();
    bool ok = tune_run(&problem, log, &r->found, ERR);
    r->found.seconds = (double)(clock_steady_ns() - begun) * 1e-9;
    r->plan = r->found.plan;
    if (!ok && is_late(w, r->found.seconds)) {
        *ERR = (duet_error){0};
        error_set(ERR, DUET_STATUS_INTERRUPTED,
                  "task %s, %s: not done after %.0f s; expected --seconds %.0f or fewer items",
                  w->task, w->strategy, w->most_seconds, ceil(w->most_seconds + w->left_seconds));
    }
    must(ok);
}

static void tune(duet_device_pair *pair, task *t, core_watch *cores, rival *r, trial_log *log,
                 const bench_options *options)
{
    subject s = {0};
    bool is_brute = r->name == names[0];
    worker w = {.subject = &s,
                .task = t->name,
                .strategy = r->name,
                .parts = is_brute ? bench_alloc(sizeof *w.parts) : NULL,
                .most_seconds = is_brute ? options->seconds : 0};
    duet_tune_def def = duet_default_tune_def();
    def.watch = watch;
    def.watch_context = &w;
    def.pair = pair;
    def.task = t;
    def.strategy = r->name;
    def.objective = "time";
    def.wait_seconds = 0;
    def.seed = options->seed;
    def.repeats = is_brute ? 1 : 3;
    subject_complete(&def);
    must(subject_prepare(&s, &def, pair, cores, ERR));
    find_plan(&w, r, log);
    if (w.parts)
        fprintf(stderr, "%s, brute: %u plans in %.1f s, %u of them not launched\n", t->name,
                r->found.plans, r->found.seconds, w.parts->passed_over);
    subject_release(&s);
}

// ---------------------------------------------------------------- rivals

static bool is_rival(const rival *rivals, uint32_t n, const duet_plan *plan)
{
    for (uint32_t i = 0; i < n; ++i)
        if (trial_log_same_plan(&rivals[i].plan, plan))
            return true;
    return false;
}

// The plan of the quickest launch that is none of the rivals' yet.
static const duet_plan *next_best(const trial_log *log, const rival *rivals, uint32_t n)
{
    const trial *best = NULL;
    for (uint32_t i = 0; i < log->n; ++i) {
        const trial *e = &log->entries[i];
        if (e->usable && (!best || e->sample.total_ns < best->sample.total_ns) &&
            !is_rival(rivals, n, &e->plan))
            best = e;
    }
    return best ? &best->plan : &rivals[0].plan;
}

// A verdict that was not sure uses one device, though sharing may be faster.
static void list_heat(rival heat[HEAT], const rival *brute, const trial_log *log)
{
    heat[0] = (rival){.name = "brute", .plan = brute->found.plan};
    heat[1] = (rival){.name = "shared", .plan = brute->found.best};
    for (uint32_t i = 2; i < HEAT; ++i)
        heat[i] = (rival){.name = "next best", .plan = *next_best(log, heat, i)};
}

static void add_plans(rival *rivals, const duet_plan *best)
{
    rivals[0].plan = *best;
    rivals[AGAIN] = (rival){.name = "the same", .plan = *best};
    rivals[A_ALONE] = (rival){.name = "A alone", .plan = rivals[1].plan};
    rivals[A_ALONE].plan.share = DUET_SHARE_ONE;
    rivals[B_ALONE] = (rival){.name = "B alone", .plan = rivals[1].plan};
    rivals[B_ALONE].plan.share = 0;
}

// ---------------------------------------------------------------- race

// One launch to warm up, for the plan before had other kernels, and one that counts.
static double launch_twice_ms(subject *s, const duet_plan *plan)
{
    measure_launch launch;
    for (int i = 0; i < 2; ++i) {
        launch = (measure_launch){0};
        must(s->kind->machine.launch(s, plan, false, &launch, ERR));
        leave_out_lost(&launch);
    }
    return (double)launch.total_ns * 1e-6;
}

// By how much a rival's time is above the first one's, in the same rounds.
static stats_interval compare_times(const rival *r, const rival *first, uint32_t rounds,
                                    double *median)
{
    double ratios[STATS_MOST];
    for (uint32_t i = 0; i < rounds; ++i)
        ratios[i] = r->ms[i] / first->ms[i];
    *median = stats_median(ratios, rounds);
    return stats_median_interval(ratios, rounds, 0.95);
}

static bool is_known(const rival *rivals, uint32_t rounds)
{
    static const double widest = 0.03;
    double median;
    bool known = true;
    for (int i = 1; i < N_NAMES; ++i) {
        if (!rivals[i].name)
            continue;
        stats_interval in = compare_times(&rivals[i], &rivals[0], rounds, &median);
        known &= in.high - in.low <= widest;
    }
    return known;
}

// Puts the rivals in an order of the round's own, so that none always follows the same other one.
static void shuffle(uint32_t *order, uint32_t n, uint32_t round)
{
    rng r = rng_stream(1, round);
    for (uint32_t i = 0; i < n; ++i)
        order[i] = i;
    for (uint32_t i = n - 1; i > 0; --i) {
        uint32_t k = rng_below(&r, i + 1), last = order[i];
        order[i] = order[k];
        order[k] = last;
    }
}

// So many rounds of all that have a name.
static void race_all(subject *s, rival *rivals, uint32_t n, uint32_t from, uint32_t to)
{
    uint32_t order[RIVALS];
    for (uint32_t run = from; run < to; ++run) {
        shuffle(order, n, run);
        for (uint32_t turn = 0; turn < n; ++turn) {
            rival *r = &rivals[order[turn]];
            if (r->name)
                r->ms[run] = launch_twice_ms(s, &r->plan);
        }
    }
}

static const rival *best_of(const rival *rivals, uint32_t n, uint32_t rounds)
{
    const rival *best = rivals;
    for (uint32_t i = 1; i < n; ++i)
        if (stats_median(rivals[i].ms, rounds) < stats_median(best->ms, rounds))
            best = &rivals[i];
    return best;
}

// Returns the number of rounds of the last race.
static uint32_t race_twice(subject *s, rival *rivals, rival *heat, uint32_t runs)
{
    race_all(s, heat, HEAT, 0, runs);
    add_plans(rivals, &best_of(heat, HEAT, runs)->plan);
    uint64_t begun = clock_steady_ns();
    uint32_t rounds = runs;
    race_all(s, rivals, RIVALS, 0, runs);
    while (rounds < STATS_MOST && !is_known(rivals, rounds) &&
           clock_ms_since(begun) < FINAL_SECONDS * 1e3) {
        race_all(s, rivals, RIVALS, rounds, rounds + 1);
        ++rounds;
    }
    return rounds;
}

// ---------------------------------------------------------------- table

static void print_rival(const task *t, const rival *r, const rival *first, uint32_t rounds,
                        uint32_t all)
{
    double median;
    stats_interval in = compare_times(r, first, rounds, &median);
    printf("| %-13s | %9llu | %-9s | %6u | %5.1f %% | %7.1f | %.4f | %9.4f ms | %+6.1f %% | "
           "%+6.1f to %+6.1f | %-6s | %s, %s |\n",
           t->name, (unsigned long long)t->items, r->name, r->found.trials,
           100.0 * r->found.trials / all, r->found.seconds, r->plan.share / (double)DUET_SHARE_ONE,
           stats_median(r->ms, rounds), 100 * (median - 1), 100 * (in.low - 1), 100 * (in.high - 1),
           in.low > 1    ? "slower"
           : in.high < 1 ? "faster"
                         : "equal",
           r->plan.variant_a, r->plan.variant_b);
}

static void print(const task *t, const rival *rivals, uint32_t rounds)
{
    for (int i = 0; i < RIVALS; ++i)
        if (rivals[i].name)
            print_rival(t, &rivals[i], &rivals[0], rounds, rivals[0].found.trials);
    fflush(stdout);
}

static void race_and_print(duet_device_pair *pair, task *t, core_watch *cores, rival *rivals,
                           const trial_log *brute, uint32_t runs)
{
    subject s;
    const duet_tune_def def = {.pair = pair, .task = t, .strategy = names[1]};
    rival *heat = bench_alloc(HEAT * sizeof *heat);
    list_heat(heat, &rivals[0], brute);
    must(subject_prepare(&s, &def, pair, cores, ERR));
    uint32_t rounds = race_twice(&s, rivals, heat, runs < STATS_MOST ? runs : STATS_MOST);
    subject_release(&s);
    print(t, rivals, rounds);
}

static void compare(duet_device_pair *pair, task *t, const bench_options *options)
{
    rival *rivals = bench_alloc(RIVALS * sizeof *rivals);
    core_watch *cores = core_watch_open();
    trial_log logs[N_NAMES] = {0};
    for (int i = 0; i < N_NAMES; ++i) {
        if (i > 1 && options->strategy && strcmp(options->strategy, names[i]) != 0)
            continue;
        rivals[i].name = names[i];
        tune(pair, t, cores, &rivals[i], &logs[i], options);
    }
    race_and_print(pair, t, cores, rivals, &logs[0], options->runs);
    for (int i = 0; i < N_NAMES; ++i)
        trial_log_free(&logs[i]);
    core_watch_close(cores);
}

static void run_task(const bench_options *options, const char *folder, int i)
{
    char path[600], n[16];
    double part = options->n > 0 ? options->n / (options->task ? tasks[i].n : tasks[0].n) : 1;
    snprintf(n, sizeof n, "%.0f",
             ceil(tasks[i].n * pow(part, options->task ? 1 : 1 / tasks[i].power)));
    const duet_setting setting = {"n", n};
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = folder;
    def.a = options->device_a ? options->device_a : "halves";
    def.b = options->device_b;
    snprintf(path, sizeof path, "%s/%s.task.lua", folder, tasks[i].name);
    task *t = must(task_load(path, &setting, 1, ERR));
    duet_device_pair *pair = must(duet_device_pair_create(&def, ERR));
    compare(pair, t, options);
    duet_device_pair_destroy(pair);
    task_destroy(t);
}

void bench_tasks(const bench_options *options)
{
    const char *folder = getenv("DUET_TASKS");
    printf("| task | items | strategy | trials | of all | seconds | share | a launch | to brute | "
           "95 %% "
           "| verdict | kernels of A, B |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    bool any = false;
    for (int i = 0; i < TASKS; ++i) {
        if (options->task && strcmp(options->task, tasks[i].name) != 0)
            continue;
        any = true;
        run_task(options, folder ? folder : DUET_EXAMPLE_TASKS, i);
    }
    must(any || error_set(ERR, DUET_STATUS_BAD_ARGUMENT, "task '%s': there is no such example",
                          options->task));
}
