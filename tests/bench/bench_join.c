// SPDX-License-Identifier: MIT
// A hundredth of the paper's scene tested against all of it, beside a step of a world that
// has both.
#include "bench.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct subject {
    duet_tree *tree;
    duet_box_query *query;
    duet_world *world;
    const duet_pose *poses; // [n], then those that are asked about
    uint32_t n, asked;
    duet_box_query_result found;
    duet_result step;
} subject;

static bool build(subject *s, duet_error *err)
{
    return duet_tree_set_objects(s->tree, DUET_OBJECT_POSES, s->poses, s->n, err);
}

static bool join(subject *s, duet_error *err)
{
    return duet_box_query_run(s->query, DUET_OBJECT_POSES, s->poses + s->n, s->asked, &s->found,
                              err);
}

static bool step(subject *s, duet_error *err)
{
    return duet_world_set_objects(s->world, DUET_OBJECT_POSES, s->poses, s->n + s->asked, err) &&
           duet_world_step(s->world, &s->step, err);
}

static struct {
    const char *name;
    bool (*run)(subject *s, duet_error *err);
    series ms, cpu;
} parts[] = {{.name = "tree", .run = build},
             {.name = "join", .run = join},
             {.name = "step of all", .run = step}};

enum { N_PARTS = sizeof parts / sizeof *parts };

static bool run_once(subject *s, bool counts, duet_error *err)
{
    for (int i = 0; i < N_PARTS; ++i) {
        uint64_t begun = clock_steady_ns();
        clock_t cpu = clock();
        if (!parts[i].run(s, err))
            return false;
        if (!counts)
            continue;
        series_add(&parts[i].ms, (double)(clock_steady_ns() - begun) * 1e-6);
        series_add(&parts[i].cpu, (double)(clock() - cpu) * 1e3 / CLOCKS_PER_SEC);
    }
    return true;
}

static bool open_subject(subject *s, duet_device_pair *pair, duet_error *err)
{
    duet_tree_def tree = duet_default_tree_def();
    duet_box_query_def query = duet_default_box_query_def();
    duet_world_def world = duet_default_world_def();
    tree.pair = world.pair = pair;
    s->tree = query.tree = duet_tree_create(&tree, err);
    s->query = s->tree ? duet_box_query_create(&query, err) : NULL;
    s->world = s->query ? duet_world_create(&world, err) : NULL;
    return s->world;
}

static bool measure(subject *s, duet_device_pair *pair, uint32_t runs, duet_error *err)
{
    bool ok = open_subject(s, pair, err);
    for (uint32_t i = 0; ok && i <= runs; ++i)
        ok = run_once(s, i > 0, err); // kernels are compiled in the first
    if (ok)
        printf("%-12s %9s %9s   %u boxes against %u: %llu hits, %llu undecided\n", "", "ms",
               "CPU ms", s->asked, s->n, (unsigned long long)s->found.n_hits,
               (unsigned long long)s->found.undecided);
    for (int i = 0; ok && i < N_PARTS; ++i)
        printf("%-12s %9.1f %9.1f\n", parts[i].name, series_median(&parts[i].ms),
               series_median(&parts[i].cpu));
    duet_world_destroy(s->world);
    duet_box_query_destroy(s->query);
    duet_tree_destroy(s->tree);
    return ok;
}

bool bench_join(const bench_options *options, duet_error *err)
{
    subject s = {.n = options->n ? options->n : 1000000};
    s.asked = s.n / 100;
    duet_pose *poses = bench_poses(s.n + s.asked, options, err);
    duet_device_pair *pair = poses ? bench_pair(options, err) : NULL;
    s.poses = poses;
    bool ok = pair && measure(&s, pair, options->runs, err);
    duet_device_pair_destroy(pair);
    free(poses);
    return ok;
}
