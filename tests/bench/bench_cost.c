// SPDX-License-Identifier: MIT
// The cost of a step of six scenes, as .ci/cost compares it with a stored base.
//
// A cost is processor time in units of a calibrating loop, which runs before each step and slows
// down as the machine does. --runs rounds repeat the same steps. Instructions are counted beside it
// if the system allows that: they hardly vary between runs, and are comparable on machines with
// equal vector units.
#define _GNU_SOURCE
#include "bench.h"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

typedef enum kind { STILL, MOVING, RAYS } kind;

static const struct {
    const char *name; // printed, and a scene that comes with Duet
    const char *scene;
    const char *n;
    kind kind;
    uint32_t skipped; // steps before the first that counts
    uint32_t steps;   // steps of a round that count
} cases[] = {
    {"paper", "paper", "100000", STILL, 2, 8},      {"paper2d", "paper2d", "100000", STILL, 2, 8},
    {"mixed", "mixed", "50000", STILL, 2, 4},       {"falling", "falling", "2000", MOVING, 40, 30},
    {"marbles", "marbles", "2000", MOVING, 40, 30}, {"rays", "paper", "50000", RAYS, 1, 2},
};

enum { N_CASES = sizeof cases / sizeof cases[0] };

// The stepped object: a world, a motion, or a tree that is built and asked.
typedef struct subject {
    duet_scene *scene;
    duet_world *world;
    duet_motion *motion;
    duet_tree *tree;
    duet_ray_query *query;
    duet_ray *rays; // one from each object
} subject;

static void open_world(subject *s, duet_device_pair *pair)
{
    s->world = bench_world(pair, duet_scene_world_def(s->scene, pair));
    must(duet_world_set_scene(s->world, s->scene, ERR));
}

static void open_motion(subject *s, duet_device_pair *pair)
{
    duet_motion_def def = duet_scene_motion_def(s->scene, pair);
    s->motion = must(duet_motion_create_from_scene(&def, s->scene, NULL, ERR));
}

// From each object's centre towards another's.
static duet_ray *make_rays(const duet_pose *poses, uint32_t n)
{
    duet_ray *rays = bench_alloc(n * sizeof *rays);
    for (uint32_t i = 0; i < n; ++i) {
        const duet_pose *to = &poses[(i * UINT64_C(7919) + 1) % n];
        for (int k = 0; k < 3; ++k) {
            rays[i].origin[k] = poses[i].centre[k];
            rays[i].direction[k] = to->centre[k] - poses[i].centre[k];
        }
        rays[i].t_max = INFINITY;
    }
    return rays;
}

static void open_tree(subject *s, duet_device_pair *pair)
{
    duet_tree_def tree_def = duet_default_tree_def();
    duet_ray_query_def def = duet_default_ray_query_def();
    tree_def.pair = pair;
    s->tree = def.tree = must(duet_tree_create(&tree_def, ERR));
    s->query = must(duet_ray_query_create(&def, ERR));
    s->rays = make_rays(duet_scene_get_objects(s->scene, DUET_OBJECT_POSES),
                        duet_scene_get_info(s->scene)->n);
}

static subject subject_open(uint32_t c, duet_device_pair *pair)
{
    static void (*const opens[])(subject * s, duet_device_pair * pair) = {
        [STILL] = open_world, [MOVING] = open_motion, [RAYS] = open_tree};
    const duet_setting setting = {"n", cases[c].n};
    subject s = {.scene = must(duet_scene_load(cases[c].scene, &setting, 1, ERR))};
    opens[cases[c].kind](&s, pair);
    return s;
}

static void subject_close(subject *s)
{
    duet_ray_query_destroy(s->query);
    duet_tree_destroy(s->tree);
    duet_motion_destroy(s->motion);
    duet_world_destroy(s->world);
    duet_scene_destroy(s->scene);
    free(s->rays);
}

static void subject_step(subject *s)
{
    duet_result result;
    duet_motion_result moved;
    duet_ray_query_result cast;
    uint32_t n = duet_scene_get_info(s->scene)->n;
    if (s->motion) {
        must(duet_motion_advance(s->motion, &moved, ERR));
    } else if (s->world) { // its objects are sent anew each time
        must(duet_world_set_scene(s->world, s->scene, ERR));
        must(duet_world_step(s->world, &result, ERR));
    } else {
        const duet_pose *poses = duet_scene_get_objects(s->scene, DUET_OBJECT_POSES);
        must(duet_tree_set_objects(s->tree, DUET_OBJECT_POSES, poses, n, ERR));
        must(duet_ray_query_run(s->query, s->rays, n, &cast, ERR));
    }
}

// Counts instructions of this thread, and of all that are started later. -1: not allowed here.
static int open_counter(void)
{
    struct perf_event_attr attr = {.type = PERF_TYPE_HARDWARE,
                                   .size = sizeof attr,
                                   .config = PERF_COUNT_HW_INSTRUCTIONS,
                                   .inherit = 1,
                                   .exclude_kernel = 1,
                                   .exclude_hv = 1};
    return (int)syscall(SYS_perf_event_open, &attr, 0, -1, -1, 0);
}

static double read_counter(int counter)
{
    uint64_t n = 0;
    return counter >= 0 && read(counter, &n, sizeof n) == sizeof n ? (double)n : 0;
}

// Arithmetic and scattered reads within a core's own cache; takes some 1 ms.
static double calibrate(void)
{
    enum { N = 1 << 14, READS = 1 << 19 };
    static float values[N];
    double begun = bench_cpu_ms();
    for (uint32_t i = 0, at = 1; i < READS; ++i) {
        at = at * 1664525u + 1013904223u;
        values[at % N] = values[i % N] * 0.5f + (float)i;
    }
    double took = bench_cpu_ms() - begun;
    return values[1] < 0 ? INFINITY : took; // never: the loop is needed for that
}

typedef struct meters {
    int instructions; // opened before the driver starts its threads
    double loop_ms;   // least of all loops so far: the unit of costs
} meters;

// The work of one round, the same in each: steps from the scene's start.
typedef struct round_cost {
    double ms, instructions; // time of all steps that count
} round_cost;

static round_cost run_round(subject *s, uint32_t c, meters *m)
{
    round_cost cost = {0};
    for (uint32_t i = 0; i < cases[c].skipped + cases[c].steps; ++i) {
        m->loop_ms = fmin(m->loop_ms, calibrate());
        double counted = read_counter(m->instructions), begun = bench_cpu_ms();
        subject_step(s);
        if (i < cases[c].skipped)
            continue;
        cost.ms += bench_cpu_ms() - begun;
        cost.instructions += read_counter(m->instructions) - counted;
    }
    return cost;
}

// The least of all rounds, because disturbances only add.
static void measure(uint32_t c, duet_device_pair *pair, uint32_t rounds, meters *m)
{
    series ms = {0}, instructions = {0};
    for (uint32_t round = 0; round < rounds; ++round) {
        subject s = subject_open(c, pair);
        round_cost cost = run_round(&s, c, m);
        subject_close(&s);
        series_add(&ms, cost.ms / cases[c].steps);
        series_add(&instructions, cost.instructions * 1e-6 / cases[c].steps);
    }
    printf("%-8s %9.3f %10.3f %9.3f\n", cases[c].name, series_least(&ms) / m->loop_ms,
           series_least(&instructions), series_least(&ms));
}

void bench_cost(const bench_options *options)
{
    meters m = {.instructions = open_counter(), .loop_ms = INFINITY};
    duet_device_pair *pair =
        options->device_a ? bench_pair(options) : must(duet_device_pair_open("halves", ERR));
    printf("%-8s %9s %10s %9s\n", "scene", "cost", "M_instr", "ms");
    for (uint32_t c = 0; c < N_CASES; ++c)
        measure(c, pair, options->runs, &m);
}
