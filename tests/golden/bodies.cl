#ifndef GPU
// bodies.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.GRAVITY0.DRAG0.FORCES0.SLEEP0.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// bodies.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.GRAVITY0.DRAG0.FORCES0.SLEEP0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ORIGIN 0
#define ANGULAR_VELOCITY 0
#define GRAVITY 0
#define DRAG 0
#define FORCES 0
#define SLEEP 0
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define FINALIZE_BODIES_ARGS \
    __global const float4 *restrict bodies, \
    uint n, \
    __global float4 *restrict centres, \
    __global float4 *restrict velocities
#define INTEGRATE_VELOCITIES_ARGS \
    __global float4 *restrict bodies, \
    uint n, \
    float h
#define PREPARE_BODIES_ARGS \
    __global const float4 *restrict velocities, \
    uint n, \
    __global float4 *restrict bodies
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/box_contact.clh"
#line 1 "kernels/dynamics/bodies.cl.in"
// as in the template: 5
#line 21 "kernels/dynamics/bodies.cl.in"
// as in the template: 3
#line 28 "kernels/dynamics/bodies.cl.in"
// as in the template: 7
#line 59 "kernels/dynamics/bodies.cl.in"
// as in the template: 15
#line 88 "kernels/dynamics/bodies.cl.in"
// as in the template: 2
#line 105 "kernels/dynamics/bodies.cl.in"
// as in the template: 3
#line 119 "kernels/dynamics/bodies.cl.in"
// as in the template: 6
#line 134 "kernels/dynamics/bodies.cl.in"
// as in the template: 3
#line 140 "kernels/dynamics/bodies.cl.in"
// as in the template: 3
#line 160 "kernels/dynamics/bodies.cl.in"
// as in the template: 2
