// SPDX-License-Identifier: MIT
// The paper's scene at random and in the order of its cells, on one device of a pair and on both.
#include "bench.h"

enum { MOST_STAGES = 64, SUBJECTS = 6 };

typedef struct subject {
    uint32_t n;
    duet_world *world;
    duet_result step;
    duet_stage least[MOST_STAGES]; // the least time of each stage
} subject;

static duet_pose *map(subject *s)
{
    return must(duet_world_map_objects(s->world, DUET_OBJECT_POSES, s->n, ERR));
}

// The objects stay where they are mapped, and are new to the world.
static void begin(void *of)
{
    map(of);
}

// On a GPU one step in sixteen has stages of its own.
static void step(void *of)
{
    subject *s = of;
    must(duet_world_step(s->world, &s->step, ERR));
    for (uint32_t i = 0; i < s->step.n_stages && i < MOST_STAGES; ++i)
        if (!s->least[i].name || s->step.stages[i].ms < s->least[i].ms)
            s->least[i] = s->step.stages[i];
}

static void put_in_order(const subject *s, duet_pose *mapped, const duet_pose *poses)
{
    uint32_t *order = NULL, n_ordered = 0;
    must(duet_world_order(s->world, &order, &n_ordered, ERR));
    for (uint32_t i = 0; i < n_ordered; ++i)
        mapped[i] = poses[order[i]];
    duet_free(order);
}

static void print(const bench_side *timed, const subject *s)
{
    printf("%-32s %8.1f ms, least %8.1f %8.1f CPU ms, least %8.1f %" PRIu64 " pairs\n", timed->name,
           series_median(&timed->ms), series_least(&timed->ms), series_median(&timed->cpu),
           series_least(&timed->cpu), s->step.pairs);
    for (uint32_t i = 0; i < MOST_STAGES && s->least[i].name; ++i)
        if (s->least[i].ms >= 0.1)
            printf("  %c %-12s %8.2f ms at least\n", "AB"[s->least[i].device], s -> least[i].name,
                   s->least[i].ms);
}

void bench_order(const bench_options *options)
{
    static const struct {
        const char *name;
        uint32_t share;
        bool in_order; // the objects
        bool ordered;  // the world is told so
    } ways[SUBJECTS] = {{"B alone, at random", 0, false, false},
                        {"B alone, in order", 0, true, false},
                        {"B alone, in order, and ordered", 0, true, true},
                        {"halves, at random", DUET_SHARE_ONE / 2, false, false},
                        {"halves, in order", DUET_SHARE_ONE / 2, true, false},
                        {"halves, in order, and ordered", DUET_SHARE_ONE / 2, true, true}};
    static subject subjects[SUBJECTS];
    static bench_side sides[SUBJECTS];
    uint32_t n = options->n ? options->n : 1000000;
    const duet_pose *poses = bench_poses(n, options);
    duet_device_pair *pair = bench_pair(options);
    for (int k = 0; k < SUBJECTS; ++k) {
        duet_world_def def = duet_default_world_def();
        def.ordered = ways[k].ordered;
        def.plan.share = ways[k].share;
        def.plan.mode = ways[k].share ? DUET_MODE_SLAB : DUET_MODE_OWN;
        subjects[k] = (subject){.n = n, .world = bench_world(pair, def)};
        duet_pose *mapped = map(&subjects[k]);
        memcpy(mapped, poses, n * sizeof *mapped);
        if (ways[k].in_order)
            put_in_order(&subjects[k], mapped, poses);
        sides[k] =
            (bench_side){.name = ways[k].name, .begin = begin, .run = step, .of = &subjects[k]};
    }
    bench_sides_run(sides, SUBJECTS, options->runs);
    for (int k = 0; k < SUBJECTS; ++k)
        print(&sides[k], &subjects[k]);
}
