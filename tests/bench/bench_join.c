// SPDX-License-Identifier: MIT
// A hundredth of the paper's scene tested against all of it, beside a step of a world that
// has both.
#include "bench.h"

static struct {
    duet_tree *tree;
    duet_box_query *query;
    duet_world *world;
    const duet_pose *poses; // [n], then those that are asked about
    uint32_t n, asked;
    duet_box_query_result found;
} s;

static void build(void *of)
{
    (void)of;
    must(duet_tree_set_objects(s.tree, DUET_OBJECT_POSES, s.poses, s.n, ERR));
}

static void join(void *of)
{
    (void)of;
    must(duet_box_query_run(s.query, DUET_OBJECT_POSES, s.poses + s.n, s.asked, &s.found, ERR));
}

static void step(void *of)
{
    duet_result result;
    (void)of;
    must(duet_world_set_objects(s.world, DUET_OBJECT_POSES, s.poses, s.n + s.asked, ERR));
    must(duet_world_step(s.world, &result, ERR));
}

void bench_join(const bench_options *options)
{
    static bench_side sides[] = {{.name = "tree", .run = build},
                                 {.name = "join", .run = join},
                                 {.name = "step of all", .run = step}};
    duet_tree_def tree = duet_default_tree_def();
    duet_box_query_def query = duet_default_box_query_def();
    s.n = options->n ? options->n : 1000000;
    s.asked = s.n / 100;
    s.poses = bench_poses(s.n + s.asked, options);
    tree.pair = bench_pair(options);
    s.tree = query.tree = must(duet_tree_create(&tree, ERR));
    s.query = must(duet_box_query_create(&query, ERR));
    s.world = bench_world(tree.pair, duet_default_world_def());
    bench_sides_run(sides, 3, options->runs);
    printf("%-12s %9s %9s   %u boxes against %u: %" PRIu64 " hits, %" PRIu64 " undecided\n", "",
           "ms", "CPU ms", s.asked, s.n, s.found.n_hits, s.found.undecided);
    for (int i = 0; i < 3; ++i)
        printf("%-12s %9.1f %9.1f\n", sides[i].name, series_median(&sides[i].ms),
               series_median(&sides[i].cpu));
}
