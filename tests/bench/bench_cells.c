// SPDX-License-Identifier: MIT
// The order of objects by cell alone, with the grid that it needs and without.
#include "bench.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct times {
    series ms, cpu;
} times;

static bool order(duet_world *world, times *t, duet_error *err)
{
    uint32_t *ids = NULL, n = 0;
    uint64_t begun = clock_steady_ns();
    clock_t cpu = clock();
    if (!duet_world_order(world, &ids, &n, err))
        return false;
    series_add(&t->ms, (double)(clock_steady_ns() - begun) * 1e-6);
    series_add(&t->cpu, (double)(clock() - cpu) * 1e3 / CLOCKS_PER_SEC);
    duet_free(ids);
    return true;
}

static void tell(const char *name, const times *t)
{
    printf("%-16s %8.1f ms, least %8.1f %8.1f CPU ms, least %8.1f\n", name, series_median(&t->ms),
           series_least(&t->ms), series_median(&t->cpu), series_least(&t->cpu));
}

// A new world each time, so that its grid is fitted, and then once more.
bool bench_cells(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options, err);
    duet_device_pair *pair = poses ? bench_pair(options, err) : NULL;
    times fitting = {0}, fitted = {0};
    bool ok = pair;
    for (uint32_t i = 0; ok && i < options->runs; ++i) {
        duet_world_def def = duet_default_world_def();
        def.pair = pair;
        duet_world *world = duet_world_create(&def, err);
        ok = world && duet_world_set_objects(world, DUET_OBJECT_POSES, poses, n, err) &&
             order(world, &fitting, err) && order(world, &fitted, err);
        duet_world_destroy(world);
    }
    if (ok) {
        tell("with its grid", &fitting);
        tell("grid is there", &fitted);
    }
    duet_device_pair_destroy(pair);
    free(poses);
    return ok;
}
