#ifndef GPU
// fat_aabbs.DIMS2.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.CONTINUOUS0.SKIN0.SLEEP0.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// fat_aabbs.DIMS3.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.CONTINUOUS0.SKIN0.SLEEP0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ORIGIN 0
#define ROTATED 0
#define ANGULAR_VELOCITY 0
#define CONTINUOUS 0
#define SKIN 0
#define SLEEP 0
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
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
// as in the template: 22
#line 35 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 2
#line 40 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 1
#line 51 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 1
#line 57 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 1
#line 64 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 3
#line 91 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 1
#line 95 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 3
#line 103 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 2
#line 106 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 1
#line 119 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 1
#line 136 "kernels/dynamics/fat_aabbs.cl.in"
// as in the template: 4
