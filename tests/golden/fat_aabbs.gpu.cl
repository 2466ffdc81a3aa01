// fat_aabbs.DIMS3.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.CONTINUOUS0.SKIN0.SLEEP0.WG64.PER_ITEM1
#define DIMS 3
#define DOUBLE 0
#define ORIGIN 0
#define ROTATED 0
#define ANGULAR_VELOCITY 0
#define CONTINUOUS 0
#define SKIN 0
#define SLEEP 0
#define WG 64
#define PER_ITEM 1
#define CHECK_FAT_AABBS_ARGS \
    __global const float4 *restrict centres, \
    __global const float4 *restrict halves, \
    float contact_margin, \
    uint n, \
    __global const float *restrict boxes, \
    volatile __global uint *restrict flags
#define COMPUTE_FAT_AABBS_ARGS \
    __global const float4 *restrict centres, \
    __global const float4 *restrict halves, \
    float aabb_margin, \
    uint n, \
    __global float *restrict boxes
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/fat_aabbs.cl.in"
// SPDX-License-Identifier: MIT
// Fat AABBs of moving bodies for the broad phase: bodies that can touch in this step
// have fat AABBs that overlap. They are rounded outward.
//
//   boxes  [n][6]  lower xyz, upper xyz
//   margin         how far apart contacts are kept, and half the skin
typedef struct {
    float4 lower;
    float4 upper;
} float_bounds;

static inline float_bounds bounds_of(real4 centre, real4 reach)
{
    float4 lower = convert_float4(centre - reach);
    float4 upper = convert_float4(centre + reach);
    float_bounds b;
    b.lower = lower - fma(fabs(lower), (float4)(0x1p-22f), (float4)(0x1p-125f));
    b.upper = upper + fma(fabs(upper), (float4)(0x1p-22f), (float4)(0x1p-125f));
    return b;
}

static inline float_bounds object_bounds(uint id, real margin, __global const real4 *centres,
#line 35 "kernels/dynamics/fat_aabbs.cl.in"
                                         __global const float4 *halves)
{
#line 40 "kernels/dynamics/fat_aabbs.cl.in"
    real4 reach = convert_real4(halves[id]);
#line 51 "kernels/dynamics/fat_aabbs.cl.in"
    real4 centre = centres[id];
#line 57 "kernels/dynamics/fat_aabbs.cl.in"
    float_bounds b = bounds_of(centre, reach + margin);
#line 64 "kernels/dynamics/fat_aabbs.cl.in"
    return b;
}

#line 91 "kernels/dynamics/fat_aabbs.cl.in"

#line 95 "kernels/dynamics/fat_aabbs.cl.in"
__kernel void compute_fat_aabbs(COMPUTE_FAT_AABBS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
#line 103 "kernels/dynamics/fat_aabbs.cl.in"
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
#line 106 "kernels/dynamics/fat_aabbs.cl.in"
        float_bounds b = object_bounds(id, aabb_margin, centres,
#line 119 "kernels/dynamics/fat_aabbs.cl.in"
                                       halves);
#line 136 "kernels/dynamics/fat_aabbs.cl.in"
        vstore3(b.lower.xyz, 2 * (size_t)id, boxes);
        vstore3(b.upper.xyz, 2 * (size_t)id + 1, boxes);
    }
}
