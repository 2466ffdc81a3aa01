// SPDX-License-Identifier: MIT
#include "support/large.h"

#include "support/devices.h"
#include "support/test.h"

#include "runtime/narrowphase/origin.h"

duet_large_pose large_poses[LARGE_MOST];

duet_world_def large_def(uint32_t dims, bool rotated)
{
    duet_world_def def = devices_def(dims);
    def.rotated = rotated;
    def.origin_edge = LARGE_EDGE;
    return def;
}

void scatter_large(uint32_t from, uint32_t n, const double at[3], double side, double most,
                   bool rotated, rng *r)
{
    for (uint32_t i = from; i < from + n; ++i) {
        double centre[3];
        large_poses[i] = (duet_large_pose){.pose.rotation = {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k) {
            centre[k] = at[k] + 0x1p-10 * floor(0x1p10 * rng_between(r, 0, side));
            large_poses[i].pose.half_extents[k] = (float)(0.5 * pow(most, rng_between(r, 0, 1)));
        }
        for (int k = 0; rotated && k < 4; ++k)
            large_poses[i].pose.rotation[k] = (float)rng_normal(r);
        assert_true(origin_place(&large_poses[i], centre, LARGE_EDGE));
    }
}
