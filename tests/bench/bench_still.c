// SPDX-License-Identifier: MIT
// What effects cost a scene that calls for none: a world's step, and the same
// with a motion of the same objects advanced beside it.
#include "bench.h"

#include "subject.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double process_cpu_ms(void)
{
    return (double)clock() * 1e3 / CLOCKS_PER_SEC;
}

static duet_motion *open_motion(const subject *s, duet_error *err)
{
    duet_motion_def def = duet_default_motion_def();
    def.pair = s->pair;
    return duet_motion_create(&def, s->def.poses, NULL, s->def.n, err);
}

// The least of both, for what disturbs only adds.
static bool measure(subject *s, duet_motion *motion, uint32_t runs, double least[2],
                    duet_error *err)
{
    series cpu[2] = {0};
    for (uint32_t run = 0; run < 2 * runs; ++run) {
        bool beside = (run ^ run / 2) & 1; // first one of them, then the other first
        duet_motion_result moved;
        double begun = process_cpu_ms();
        if (!subject_step(s, err) || (beside && !duet_motion_advance(motion, &moved, err)))
            return false;
        series_add(&cpu[beside], process_cpu_ms() - begun);
    }
    for (int i = 0; i < 2; ++i)
        least[i] = series_least(&cpu[i]);
    return true;
}

bool bench_still(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 200000;
    duet_pose *poses = bench_poses(n, options, err);
    subject *s = calloc(1, sizeof *s);
    subject_def def = {.name = "still",
                       .device_a = options->device,
                       .device_b = options->device,
                       .variant = "simd",
                       .mode = DUET_MODE_OWN,
                       .poses = poses,
                       .n = n};
    double least[2];
    duet_motion *motion = NULL;
    bool ok = poses && s && subject_open(s, &def, err);
    if (ok)
        motion = open_motion(s, err);
    ok = motion && measure(s, motion, options->runs, least, err);
    if (ok)
        printf("%u objects, processor time of a step, ms: %.2f alone, %.2f beside a motion that "
               "calls for nothing: ratio %.3f; wanted: at most 1.02\n",
               n, least[0], least[1], least[1] / least[0]);
    duet_motion_destroy(motion);
    if (s)
        subject_close(s);
    free(s);
    free(poses);
    return ok;
}
