// SPDX-License-Identifier: MIT
// Rays through the paper's scene, as many as there are boxes: how long the tree and the
// rays take, for each question.
#include "bench.h"

typedef struct subject {
    duet_tree *tree;
    duet_ray_query *query;
    duet_ray_query_result found;
    const duet_pose *poses;
    const duet_ray *rays;
    uint32_t n;
} subject;

// From anywhere in the world to anywhere.
static duet_ray *random_rays(uint32_t n, uint64_t seed, const duet_pose *poses)
{
    duet_ray *rays = bench_alloc(n * sizeof *rays);
    rng r = rng_seed(seed + 1);
    for (uint32_t i = 0; i < n; ++i) {
        const duet_pose *from = &poses[rng_below(&r, n)], *to = &poses[rng_below(&r, n)];
        for (int k = 0; k < 3; ++k) {
            rays[i].origin[k] = from->centre[k] + (float)rng_between(&r, -1, 1);
            rays[i].direction[k] = to->centre[(k + 1) % 3] - rays[i].origin[k];
        }
        rays[i].t_max = INFINITY;
    }
    return rays;
}

static void build(void *of)
{
    const subject *s = of;
    must(duet_tree_set_objects(s->tree, DUET_OBJECT_POSES, s->poses, s->n, ERR));
}

static void cast(void *of)
{
    subject *s = of;
    must(duet_ray_query_run(s->query, s->rays, s->n, &s->found, ERR));
}

static uint64_t count_met(const duet_ray_query_result *found)
{
    uint64_t n = 0;
    for (uint64_t i = 0; i < found->n_hits; ++i)
        n += found->hits[i].id != DUET_NO_OBJECT;
    return n;
}

static void measure(subject s, duet_query_wants wants, duet_device_pair *pair, uint32_t runs)
{
    duet_tree_def tree_def = duet_default_tree_def();
    duet_ray_query_def def = duet_default_ray_query_def();
    tree_def.pair = pair;
    def.wants = wants;
    s.tree = def.tree = must(duet_tree_create(&tree_def, ERR));
    s.query = must(duet_ray_query_create(&def, ERR));
    bench_side sides[2] = {{.run = build, .of = &s}, {.run = cast, .of = &s}};
    bench_sides_run(sides, 2, runs);
    double ms = series_median(&sides[1].ms);
    printf("%-8s %9.1f %9.1f %9.1f %9.1f %10" PRIu64 " %8.2f\n", duet_query_wants_name(wants),
           series_median(&sides[0].ms), series_median(&sides[0].cpu), ms,
           series_median(&sides[1].cpu), count_met(&s.found), s.n / ms * 1e-3);
    duet_ray_query_destroy(s.query);
    duet_tree_destroy(s.tree);
}

void bench_rays(const bench_options *options)
{
    subject s = {.n = options->n ? options->n : 1000000};
    s.poses = bench_poses(s.n, options);
    s.rays = random_rays(s.n, options->seed, s.poses);
    duet_device_pair *pair = bench_pair(options);
    printf("%-8s %9s %9s %9s %9s %10s %8s\n", "wants", "tree ms", "CPU ms", "rays ms", "CPU ms",
           "hits", "M rays/s");
    for (int wants = DUET_QUERY_CLOSEST; wants <= DUET_QUERY_ANY; ++wants)
        measure(s, (duet_query_wants)wants, pair, options->runs);
}
