// SPDX-License-Identifier: MIT
// Rays through the paper's scene, as many as there are boxes: how long the tree and the
// rays take, for each question.
#include "bench.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/rng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct subject {
    duet_tree *tree_of_boxes;
    duet_ray_query *query;
    duet_ray_query_result found;
    series tree, tree_cpu, cast, cast_cpu;
} subject;

// From anywhere in the world to anywhere.
static duet_ray *random_rays(uint32_t n, uint64_t seed, const duet_pose *poses)
{
    duet_ray *rays = calloc(n, sizeof *rays);
    rng r = rng_seed(seed + 1);
    for (uint32_t i = 0; rays && i < n; ++i) {
        const duet_pose *from = &poses[rng_below(&r, n)], *to = &poses[rng_below(&r, n)];
        for (int k = 0; k < 3; ++k) {
            rays[i].origin[k] = from->centre[k] + (float)rng_between(&r, -1, 1);
            rays[i].direction[k] = to->centre[(k + 1) % 3] - rays[i].origin[k];
        }
        rays[i].t_max = INFINITY;
    }
    return rays;
}

static double cpu_ms(void)
{
    return (double)clock() * 1e3 / CLOCKS_PER_SEC;
}

static bool run_once(subject *s, const duet_pose *poses, const duet_ray *rays, uint32_t n,
                     duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    double cpu = cpu_ms();
    if (!duet_tree_set_objects(s->tree_of_boxes, DUET_OBJECT_POSES, poses, n, err))
        return false;
    uint64_t built = clock_steady_ns();
    double built_cpu = cpu_ms();
    if (!duet_ray_query_run(s->query, rays, n, &s->found, err))
        return false;
    series_add(&s->tree, (double)(built - begun) * 1e-6);
    series_add(&s->tree_cpu, built_cpu - cpu);
    series_add(&s->cast, (double)(clock_steady_ns() - built) * 1e-6);
    series_add(&s->cast_cpu, cpu_ms() - built_cpu);
    return true;
}

static uint64_t count_met(const duet_ray_query_result *found)
{
    uint64_t n = 0;
    for (uint64_t i = 0; i < found->n_hits; ++i)
        n += found->hits[i].id != DUET_NO_OBJECT;
    return n;
}

static bool measure(duet_query_wants wants, duet_device_pair *pair, const duet_pose *poses,
                    const duet_ray *rays, uint32_t n, uint32_t runs, duet_error *err)
{
    subject *s = calloc(1, sizeof *s);
    duet_tree_def tree_def = duet_default_tree_def();
    duet_ray_query_def def = duet_default_ray_query_def();
    tree_def.pair = pair;
    def.wants = wants;
    if (!s)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for the samples");
    s->tree_of_boxes = def.tree = duet_tree_create(&tree_def, err);
    s->query = def.tree ? duet_ray_query_create(&def, err) : NULL;
    bool ok = s->query;
    for (uint32_t i = 0; ok && i <= runs; ++i) {
        ok = run_once(s, poses, rays, n, err);
        if (i == 0) // kernels are compiled
            s->tree.n = s->tree_cpu.n = s->cast.n = s->cast_cpu.n = 0;
    }
    if (ok)
        printf("%-8s %9.1f %9.1f %9.1f %9.1f %10llu %8.2f\n", duet_query_wants_name(wants),
               series_median(&s->tree), series_median(&s->tree_cpu), series_median(&s->cast),
               series_median(&s->cast_cpu), (unsigned long long)count_met(&s->found),
               n / series_median(&s->cast) * 1e-3);
    duet_ray_query_destroy(s->query);
    duet_tree_destroy(s->tree_of_boxes);
    free(s);
    return ok;
}

bool bench_rays(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options, err);
    duet_ray *rays = poses ? random_rays(n, options->seed, poses) : NULL;
    duet_device_pair *pair = rays ? bench_pair(options, err) : NULL;
    bool ok = pair || error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u rays", n);
    if (ok)
        printf("%-8s %9s %9s %9s %9s %10s %8s\n", "wants", "tree ms", "CPU ms", "rays ms", "CPU ms",
               "hits", "M rays/s");
    for (int wants = DUET_QUERY_CLOSEST; ok && wants <= DUET_QUERY_ANY; ++wants)
        ok = measure((duet_query_wants)wants, pair, poses, rays, n, options->runs, err);
    duet_device_pair_destroy(pair);
    free(rays);
    free(poses);
    return ok;
}
