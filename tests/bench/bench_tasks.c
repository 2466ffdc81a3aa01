// SPDX-License-Identifier: MIT
// The six example tasks: what each strategy finds of kernels and share, beside every plan of an
// even grid (brute, its best shared plan, and the next best of its launches). The winners, and each
// device alone by the kernels that the default strategy found, then race in turn; each is compared
// with the best of brute force's, round by round. A launch's time is without what other programs
// took of it. --n: items of saxpy; the others have as much less work. --task: one, of --n items.
//
// Brute force counts a plan, but does not launch it, if one part of it alone took 1.3 times as long
// as the quickest plan. Every strategy tells how far it is, and the bench fails if brute force
// takes longer than --seconds.
#include "bench.h"
#include "part_times.h"

#include "base/clock.h"
#include "base/error.h"
#include "runtime/task/task.h"
#include "tuner/stats.h"
#include "tuner/subject.h"
#include "tuner/tune.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    SHARED = N_NAMES,
    FEW = 4, // more of brute force's best
    RIVALS = N_NAMES + 1 + FEW + 2,
    TELL_SECONDS = 5,
    TASKS = sizeof tasks / sizeof *tasks
};

typedef struct rival {
    const char *name;
    duet_plan plan;
    duet_tune_outcome found; // of a strategy
    double ms[SERIES_ROOM];
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

static bool launch_alone(subject *s, const duet_plan *plan, bool staged, measure_launch *launch,
                         duet_error *err)
{
    if (!s->kind->machine.launch(s, plan, staged, launch, err))
        return false;
    leave_out_lost(launch);
    return true;
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
static bool find_plan(worker *w, rival *r, trial_log *log, duet_error *err)
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
    bool ok = tune_run(&problem, log, &r->found, err);
    r->found.seconds = (double)(clock_steady_ns() - begun) * 1e-9;
    r->plan = r->found.plan;
    if (!ok && is_late(w, r->found.seconds)) {
        *err = (duet_error){0};
        return error_set(err, DUET_STATUS_INTERRUPTED,
                         "task %s, %s: not done after %.0f s; expected --seconds %.0f or fewer "
                         "items",
                         w->task, w->strategy, w->most_seconds,
                         ceil(w->most_seconds + w->left_seconds));
    }
    return ok;
}

static bool tune(duet_device_pair *pair, task *t, core_watch *cores, rival *r, trial_log *log,
                 const bench_options *options, duet_error *err)
{
    subject s = {0};
    bool is_brute = r->name == names[0];
    worker w = {.subject = &s,
                .task = t->name,
                .strategy = r->name,
                .parts = is_brute ? calloc(1, sizeof *w.parts) : NULL,
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
    bool ok = subject_prepare(&s, &def, pair, cores, err) && find_plan(&w, r, log, err);
    if (ok && w.parts)
        fprintf(stderr, "%s, brute: %u plans in %.1f s, %u of them not launched\n", t->name,
                r->found.plans, r->found.seconds, w.parts->passed_over);
    subject_release(&s);
    free(w.parts);
    return ok;
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
static void add_plans(rival *rivals, const trial_log *brute)
{
    uint32_t n = SHARED;
    rivals[n++] = (rival){.name = "shared", .plan = rivals[0].found.best};
    for (int i = 0; i < FEW; ++i, ++n)
        rivals[n] = (rival){.name = "next best", .plan = *next_best(brute, rivals, n)};
    for (uint32_t a = 0; a < 2; ++a, ++n) {
        rivals[n] = (rival){.name = a ? "A alone" : "B alone", .plan = rivals[1].plan};
        rivals[n].plan.share = a * DUET_SHARE_ONE;
    }
}

// ---------------------------------------------------------------- race

// One launch to warm up, for the plan before had other kernels, and one that counts.
static bool launch_twice(subject *s, const duet_plan *plan, double *ms, duet_error *err)
{
    measure_launch launch;
    for (int i = 0; i < 2; ++i) {
        launch = (measure_launch){0};
        if (!launch_alone(s, plan, false, &launch, err))
            return false;
    }
    *ms = (double)launch.total_ns * 1e-6;
    return true;
}

static bool race_all(duet_device_pair *pair, task *t, core_watch *cores, rival *rivals,
                     uint32_t runs, duet_error *err)
{
    subject s;
    const duet_tune_def def = {.pair = pair, .task = t, .strategy = names[1]};
    bool ok = subject_prepare(&s, &def, pair, cores, err);
    for (uint32_t run = 0; ok && run < runs; ++run)
        for (uint32_t turn = 0; ok && turn < RIVALS; ++turn) {
            rival *r = &rivals[(turn + run) % RIVALS];
            ok = !r->name || launch_twice(&s, &r->plan, &r->ms[run], err);
        }
    subject_release(&s);
    return ok;
}

// ---------------------------------------------------------------- table

// The plan of brute force's with the least median.
static const rival *best_of_brute(const rival *rivals, uint32_t runs)
{
    const rival *best = &rivals[0];
    for (int i = SHARED; i < SHARED + 1 + FEW; ++i)
        if (stats_median(rivals[i].ms, runs) < stats_median(best->ms, runs))
            best = &rivals[i];
    return best;
}

static void print_rival(const task *t, const rival *r, const rival *best, uint32_t runs,
                        uint32_t all)
{
    double ratios[SERIES_ROOM];
    for (uint32_t i = 0; i < runs; ++i)
        ratios[i] = r->ms[i] / best->ms[i];
    stats_interval in = stats_median_interval(ratios, runs, 0.95);
    printf("| %-13s | %9llu | %-9s | %6u | %5.1f %% | %7.1f | %.4f | %9.4f ms | %+6.1f %% | "
           "%+6.1f to %+6.1f | %s, %s |\n",
           t->name, (unsigned long long)t->items, r->name, r->found.trials,
           100.0 * r->found.trials / all, r->found.seconds, r->plan.share / (double)DUET_SHARE_ONE,
           stats_median(r->ms, runs), 100 * (stats_median(ratios, runs) - 1), 100 * (in.low - 1),
           100 * (in.high - 1), r->plan.variant_a, r->plan.variant_b);
}

static void print(const task *t, const rival *rivals, uint32_t runs)
{
    for (int i = 0; i < RIVALS; ++i)
        if (rivals[i].name)
            print_rival(t, &rivals[i], best_of_brute(rivals, runs), runs, rivals[0].found.trials);
    fflush(stdout);
}

static bool compare(duet_device_pair *pair, task *t, const bench_options *options, duet_error *err)
{
    rival *rivals = calloc(RIVALS, sizeof *rivals);
    if (!rivals)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for plans");
    core_watch *cores = core_watch_open();
    trial_log logs[N_NAMES] = {0};
    bool ok = true;
    for (int i = 0; ok && i < N_NAMES; ++i) {
        if (i > 1 && options->strategy && strcmp(options->strategy, names[i]) != 0)
            continue;
        rivals[i].name = names[i];
        ok = tune(pair, t, cores, &rivals[i], &logs[i], options, err);
    }
    add_plans(rivals, &logs[0]);
    ok = ok && race_all(pair, t, cores, rivals, options->runs, err);
    if (ok)
        print(t, rivals, options->runs);
    for (int i = 0; i < N_NAMES; ++i)
        trial_log_free(&logs[i]);
    core_watch_close(cores);
    free(rivals);
    return ok;
}

static bool run_task(const bench_options *options, const char *folder, int i, duet_error *err)
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
    task *t = task_load(path, &setting, 1, err);
    duet_device_pair *pair = t ? duet_device_pair_create(&def, err) : NULL;
    bool ok = pair && compare(pair, t, options, err);
    duet_device_pair_destroy(pair);
    task_destroy(t);
    return ok;
}

bool bench_tasks(const bench_options *options, duet_error *err)
{
    const char *folder = getenv("DUET_TASKS");
    printf("| task | items | strategy | trials | of all | seconds | share | a launch | to brute | "
           "95 %% "
           "| kernels of A, B |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    bool ok = true, any = false;
    for (int i = 0; ok && i < TASKS; ++i) {
        if (options->task && strcmp(options->task, tasks[i].name) != 0)
            continue;
        any = true;
        ok = run_task(options, folder ? folder : DUET_EXAMPLE_TASKS, i, err);
    }
    return ok && (any || error_set(err, DUET_STATUS_BAD_ARGUMENT,
                                   "task '%s': there is no such example", options->task));
}
