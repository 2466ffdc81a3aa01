// SPDX-License-Identifier: MIT
// The loss by a plan that is looked up, beside a fresh tuning and beside the default plan: --runs
// sizes and scenes are drawn around a store of the paper's scene with a half, one, two and four
// times --n objects. The plans step in turn.
//
// If both devices are CPUs a step takes the processor time of the host and of the busiest other
// thread: on a busy machine the clock tells of other programs. Else it takes what the clock says.
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include "base/compare.h"
#include "tuner/duet_tune.h"

#include <dirent.h>
#include <unistd.h>

enum { WARM_UP = 3, ROUNDS = 31 };

// The plan that was looked up steps in two worlds: what tells them apart is noise.
enum { LOOKED_UP, AGAIN, TUNED, DEFAULT, PLANS };

// The scene that is tuned, and one of its family that is not alike.
static const char *const scenes[] = {"paper", "paper", "clustered"};

enum { N_SCENES = sizeof scenes / sizeof *scenes };

typedef struct losses {
    duet_device_pair *pair;
    bool by_clock;
    const char *known;    // the store that is looked up in
    const char *fresh;    // the one of fresh tunings
    series behind[PLANS]; // %
} losses;

// Processor time of each thread of the process, as the kernel counts it.
enum { THREAD_TIMES_ROOM = 512 };

typedef struct thread_times {
    struct {
        int id;
        uint64_t ns;
    } threads[THREAD_TIMES_ROOM];
    uint32_t n; // 0: the system does not tell
} thread_times;

static void thread_times_read(thread_times *t)
{
    DIR *tasks = opendir("/proc/self/task");
    t->n = 0;
    for (struct dirent *task; tasks && (task = readdir(tasks)) && t->n < THREAD_TIMES_ROOM;) {
        char path[300];
        snprintf(path, sizeof path, "/proc/self/task/%s/schedstat", task->d_name);
        FILE *file = fopen(path, "r");
        if (file && fscanf(file, "%" SCNu64, &t->threads[t->n].ns) == 1)
            t->threads[t->n++].id = atoi(task->d_name);
        if (file)
            fclose(file);
    }
    if (tasks)
        closedir(tasks);
}

static uint64_t time_of(const thread_times *t, int id)
{
    for (uint32_t i = 0; i < t->n; ++i)
        if (t->threads[i].id == id)
            return t->threads[i].ns;
    return 0;
}

// The main thread's time since, and the busiest other thread's.
static double thread_times_since_ms(const thread_times *before, const thread_times *now)
{
    uint64_t host = 0, busiest = 0;
    for (uint32_t i = 0; i < now->n; ++i) {
        int id = now->threads[i].id;
        uint64_t ns = now->threads[i].ns - time_of(before, id);
        if (id == getpid())
            host = ns;
        else if (ns > busiest)
            busiest = ns;
    }
    return (double)(host + busiest) * 1e-6;
}

static duet_scene *load(const char *name, uint32_t n, uint64_t seed)
{
    char number[16], chosen[24];
    snprintf(number, sizeof number, "%u", n);
    snprintf(chosen, sizeof chosen, "%" PRIu64, seed);
    duet_setting settings[] = {{"n", number}, {"seed", chosen}};
    return must(duet_scene_load(name, settings, 2, ERR));
}

static duet_tune_outcome tune(const losses *l, const duet_scene *scene, const char *store,
                              uint64_t seed)
{
    duet_tune_def def = duet_default_tune_def();
    duet_tune_outcome outcome;
    def.pair = l->pair;
    def.scene = scene;
    def.store = store;
    def.seed = seed;
    must(duet_tune_run(&def, &outcome, ERR));
    return outcome;
}

static void fill(const losses *l, uint32_t n, uint64_t seed)
{
    for (int i = -1; i <= 2; ++i) {
        duet_scene *scene = load("paper", (uint32_t)ldexp(n, i), seed);
        duet_tune_outcome outcome = tune(l, scene, l->known, seed);
        duet_scene_destroy(scene);
        printf("stored: %u objects, share %.4f, mode %s, %s, %s, %.3f ms, gain %+.1f %% %s\n",
               outcome.objects, outcome.plan.share / (double)DUET_SHARE_ONE,
               duet_mode_name(outcome.plan.mode), outcome.plan.variant_a, outcome.plan.variant_b,
               outcome.step_ms, 100 * outcome.gain, outcome.verdict);
    }
}

// A world for each plan, so that none pays for the change to its kernels.
static double step(const losses *l, duet_world *world)
{
    thread_times before, now;
    duet_result result;
    must(duet_world_step(world, &result, ERR)); // fills the caches that the others emptied
    thread_times_read(&before);
    must(duet_world_step(world, &result, ERR));
    thread_times_read(&now);
    return l->by_clock ? result.total_ms : thread_times_since_ms(&before, &now);
}

// By the median ratio of a round's times, in %.
static void race(const losses *l, duet_world *const worlds[PLANS], double behind[PLANS])
{
    series ratios[PLANS] = {0};
    for (int round = -WARM_UP; round < ROUNDS; ++round) {
        double ms[PLANS];
        for (int i = 0; i < PLANS; ++i)
            ms[i] = step(l, worlds[i]);
        for (int i = 0; round >= 0 && i < PLANS; ++i)
            series_add(&ratios[i], ms[LOOKED_UP] / ms[i]);
    }
    for (int i = 0; i < PLANS; ++i)
        behind[i] = 100 * (series_median(&ratios[i]) - 1);
}

static void print_plan(const duet_plan *plan)
{
    printf(" | %.4f %-4s %s, %s", plan->share / (double)DUET_SHARE_ONE, duet_mode_name(plan->mode),
           plan->variant_a, plan->variant_b);
}

static void compare(losses *l, const duet_scene *scene, uint64_t seed,
                    duet_world *const worlds[PLANS])
{
    double behind[PLANS];
    duet_profile profile;
    for (int i = 0; i < PLANS; ++i)
        must(duet_world_set_scene(worlds[i], scene, ERR));
    must(duet_world_load_profile(worlds[LOOKED_UP], l->known, &profile, ERR));
    duet_tune_outcome outcome = tune(l, scene, l->fresh, seed);
    if (profile.grade < DUET_GRADE_STALE)
        must(duet_world_set_plan(worlds[AGAIN], &profile.plan, ERR));
    must(duet_world_set_plan(worlds[TUNED], &outcome.plan, ERR));
    race(l, worlds, behind);
    for (int i = 0; i < PLANS; ++i)
        series_add(&l->behind[i], behind[i]);
    printf(" | %-12s", duet_grade_name(profile.grade));
    for (int i = AGAIN; i < PLANS; ++i)
        print_plan(duet_world_get_plan(worlds[i]));
    printf(" | %+6.1f %% | %+6.1f %% | %+6.1f %% |\n", behind[TUNED], behind[DEFAULT],
           behind[AGAIN]);
    fflush(stdout);
}

static void draw(losses *l, uint32_t n, rng *r)
{
    const char *name = scenes[rng_below(r, N_SCENES)];
    uint64_t seed = 1 + rng_below(r, 1000);
    uint32_t drawn = (uint32_t)(n * exp2(rng_between(r, -2, 3)));
    duet_scene *scene = load(name, drawn, seed);
    duet_world *worlds[PLANS];
    for (int i = 0; i < PLANS; ++i)
        worlds[i] = bench_world(l->pair, duet_scene_world_def(scene, l->pair));
    printf("| %-9s | %8u", name, drawn);
    compare(l, scene, seed, worlds);
    for (int i = 0; i < PLANS; ++i)
        duet_world_destroy(worlds[i]);
    duet_scene_destroy(scene);
}

static void print_losses(const char *name, const series *s)
{
    double sorted[SERIES_ROOM];
    memcpy(sorted, s->samples, s->n * sizeof *sorted);
    qsort(sorted, s->n, sizeof *sorted, compare_double);
    uint32_t behind = 0;
    for (uint32_t i = 0; i < s->n; ++i)
        behind += sorted[i] > 3;
    printf("behind %-14s median %+.1f %%, 95 %% of them below %+.1f %%, at worst %+.1f %%; "
           "%u of %u by more than 3 %%\n",
           name, series_median(s), sorted[(uint32_t)(0.95 * (s->n - 1) + 0.5)], sorted[s->n - 1],
           behind, s->n);
}

static bool is_cpu(const losses *l, int device)
{
    return duet_device_pair_get_info(l->pair, device)->kind == DUET_KIND_CPU;
}

void bench_loss(const bench_options *options)
{
    uint32_t n = options->n ? options->n : 200000;
    rng r = rng_seed(options->seed);
    bench_folder folder = bench_make_folder();
    static losses l;
    l.known = folder.stores[0];
    l.fresh = folder.stores[1];
    l.pair = bench_pair(options);
    l.by_clock = !(is_cpu(&l, 0) && is_cpu(&l, 1));
    fill(&l, n, options->seed);
    printf("| scene | objects | grade | looked up | tuned | default | behind tuned | behind "
           "default | behind itself |\n|---|---|---|---|---|---|---|---|---|\n");
    for (uint32_t i = 0; i < options->runs; ++i)
        draw(&l, n, &r);
    print_losses("a tuning", &l.behind[TUNED]);
    print_losses("the default", &l.behind[DEFAULT]);
    print_losses("itself, noise", &l.behind[AGAIN]);
    bench_remove_folder(&folder);
}
