// SPDX-License-Identifier: MIT
#include "paper_scene.h"

#include "base/rng.h"

#include <math.h>
#include <stdlib.h>

float paper_world(uint32_t n)
{
    return (float)cbrt(8.0 * n);
}

duet_pose *paper_poses(uint32_t n, uint64_t seed)
{
    enum { PAGE = 4096 };
    size_t bytes = ((size_t)n * sizeof(duet_pose) + PAGE) / PAGE * PAGE;
    duet_pose *poses = aligned_alloc(PAGE, bytes);
    if (!poses)
        return NULL;
    rng r = rng_seed(seed);
    double world = paper_world(n);
    for (uint32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            poses[i].centre[k] = (float)rng_between(&r, 0, world);
            poses[i].half_extents[k] = 0.5f;
        }
        for (int k = 0; k < 4; ++k)
            poses[i].rotation[k] = (float)rng_normal(&r);
    }
    return poses;
}
