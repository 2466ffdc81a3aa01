// SPDX-License-Identifier: MIT
// What effects cost a scene that calls for none: a world's step, and the same
// with a motion of the same objects advanced beside it.
#include "subject.h"

void bench_still(const bench_options *options)
{
    uint32_t n = options->n ? options->n : 200000;
    const duet_pose *poses = bench_poses(n, options);
    subject *s = subject_alone(options, "simd", poses, n);
    duet_motion_def def = duet_default_motion_def();
    def.pair = s->pair;
    duet_motion *motion = must(duet_motion_create(&def, poses, NULL, n, ERR));
    series cpu[2] = {0};
    for (uint32_t run = 0; run < 2 * options->runs; ++run) {
        bool beside = (run ^ run / 2) & 1; // first one of them, then the other first
        duet_motion_result moved;
        double begun = bench_cpu_ms();
        subject_step(s);
        if (beside)
            must(duet_motion_advance(motion, &moved, ERR));
        series_add(&cpu[beside], bench_cpu_ms() - begun);
    }
    // The least of both, for what disturbs only adds.
    double alone = series_least(&cpu[0]), both = series_least(&cpu[1]);
    printf("%u objects, processor time of a step, ms: %.2f alone, %.2f beside a motion that "
           "calls for nothing: ratio %.3f; wanted: at most 1.02\n",
           n, alone, both, both / alone);
}
