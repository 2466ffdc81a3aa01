#ifndef GPU
// update_sleep.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.FRICTION0.SENSORS0.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// update_sleep.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.FRICTION0.SENSORS0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ORIGIN 0
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define SENSORS 0
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define MOVE_SLEEPERS_ARGS \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint2 *restrict links, \
    __global const uint *restrict asleep, \
    __global const float4 *restrict velocities, \
    uint n, \
    float margin, \
    uint round, \
    float dt, \
    __global float *restrict contacts, \
    __global float4 *restrict bodies, \
    __global float4 *restrict centres, \
    __global float *restrict rests
#define PUSH_SLEEPERS_ARGS \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint *restrict return_starts, \
    __global const uint *restrict returns, \
    __global const uint2 *restrict links, \
    __global const uint *restrict asleep, \
    __global const float4 *restrict velocities, \
    uint n, \
    float margin, \
    uint round, \
    __global float *restrict contacts, \
    __global float4 *restrict bodies
#define UPDATE_SLEEP_ARGS \
    __global const uint2 *restrict links, \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint *restrict return_starts, \
    __global const uint *restrict returns, \
    uint n, \
    __global const float *restrict rests, \
    __global const float4 *restrict velocities, \
    float sleep_after, \
    float dt, \
    __global uint *restrict asleep, \
    volatile __global uint *restrict flags
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 17
#line 24 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 12
#line 39 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 3
#line 49 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 11
#line 64 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 8
#line 76 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 10
#line 94 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 35
#line 132 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 28
#line 164 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 41
#line 209 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 6
#line 218 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 19
#line 240 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 11
#line 254 "kernels/dynamics/update_sleep.cl.in"
// as in the template: 5
