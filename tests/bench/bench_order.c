// SPDX-License-Identifier: MIT
// The paper's scene at random and in the order of its cells, on one device of a pair and on both.
#include "bench.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_STAGES = 64 };

typedef struct subject {
    const char *name;
    uint32_t share;
    bool in_order; // the objects
    bool ordered;  // the world is told so
    duet_world *world;
    duet_result step;
    series ms, cpu;
    duet_stage least[MOST_STAGES]; // the least time of each stage
} subject;

enum { SUBJECTS = 6 };

static bool put_in_order(const subject *s, duet_pose *mapped, const duet_pose *poses, uint32_t n,
                         duet_error *err)
{
    uint32_t *order = NULL, n_ordered = 0;
    memcpy(mapped, poses, n * sizeof *mapped);
    if (s->in_order && !duet_world_order(s->world, &order, &n_ordered, err))
        return false;
    for (uint32_t i = 0; i < n_ordered; ++i)
        mapped[i] = poses[order[i]];
    duet_free(order);
    return true;
}

static bool open_world(subject *s, duet_device_pair *pair, const duet_pose *poses, uint32_t n,
                       duet_error *err)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.ordered = s->ordered;
    def.plan.share = s->share;
    def.plan.mode = s->share ? DUET_MODE_SLAB : DUET_MODE_OWN;
    s->world = duet_world_create(&def, err);
    duet_pose *mapped =
        s->world ? duet_world_map_objects(s->world, DUET_OBJECT_POSES, n, err) : NULL;
    return mapped && put_in_order(s, mapped, poses, n, err);
}

static void keep_least(subject *s)
{
    for (uint32_t i = 0; i < s->step.n_stages && i < MOST_STAGES; ++i)
        if (!s->least[i].name || s->step.stages[i].ms < s->least[i].ms)
            s->least[i] = s->step.stages[i];
}

// The objects stay where they are mapped, and are new to the world.
static bool step(subject *s, uint32_t n, bool counts, duet_error *err)
{
    if (!duet_world_map_objects(s->world, DUET_OBJECT_POSES, n, err))
        return false;
    uint64_t begun = clock_steady_ns();
    clock_t cpu = clock();
    if (!duet_world_step(s->world, &s->step, err))
        return false;
    if (counts) {
        series_add(&s->ms, (double)(clock_steady_ns() - begun) * 1e-6);
        series_add(&s->cpu, (double)(clock() - cpu) * 1e3 / CLOCKS_PER_SEC);
        keep_least(s); // on a GPU one step in sixteen has stages of its own
    }
    return true;
}

static void tell(const subject *s)
{
    printf("%-32s %8.1f ms, least %8.1f %8.1f CPU ms, least %8.1f %llu pairs\n", s->name,
           series_median(&s->ms), series_least(&s->ms), series_median(&s->cpu),
           series_least(&s->cpu), (unsigned long long)s->step.pairs);
    for (uint32_t i = 0; i < MOST_STAGES && s->least[i].name; ++i)
        if (s->least[i].ms >= 0.1)
            printf("  %c %-12s %8.2f ms at least\n", "AB"[s->least[i].device], s -> least[i].name,
                   s->least[i].ms);
}

bool bench_order(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options, err);
    duet_device_pair *pair = poses ? bench_pair(options, err) : NULL;
    subject subjects[SUBJECTS] = {
        {.name = "B alone, at random"},
        {.name = "B alone, in order", .in_order = true},
        {.name = "B alone, in order, and ordered", .in_order = true, .ordered = true},
        {.name = "halves, at random", .share = DUET_SHARE_ONE / 2},
        {.name = "halves, in order", .share = DUET_SHARE_ONE / 2, .in_order = true},
        {.name = "halves, in order, and ordered",
         .share = DUET_SHARE_ONE / 2,
         .in_order = true,
         .ordered = true}};
    bool ok = pair;
    for (int k = 0; ok && k < SUBJECTS; ++k)
        ok = open_world(&subjects[k], pair, poses, n, err);
    for (uint32_t i = 0; ok && i <= options->runs; ++i) // kernels are compiled in the first
        for (int k = 0; ok && k < SUBJECTS; ++k)
            ok = step(&subjects[k], n, i > 0, err);
    for (int k = 0; k < SUBJECTS; ++k) {
        if (ok)
            tell(&subjects[k]);
        duet_world_destroy(subjects[k].world);
    }
    duet_device_pair_destroy(pair);
    free(poses);
    return ok;
}
