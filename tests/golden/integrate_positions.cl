#ifndef GPU
// integrate_positions.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.GYRO0.FRICTION0.LANES8.BLOCK8.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// integrate_positions.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.GYRO0.FRICTION0.LANES1.BLOCK32.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ANGULAR_VELOCITY 0
#define GYRO 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#ifndef GPU
#define LANES 8
#define BLOCK 8
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define LANES 1
#define BLOCK 32
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define INTEGRATE_POSITIONS_ARGS \
    __global float4 *restrict bodies, \
    uint n, \
    float h
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/dynamics/vector.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/constraint.clh"
#line 1 "kernels/dynamics/turn.clh"
#line 1 "kernels/dynamics/integrate_positions.cl.in"
// as in the template: 5
#line 7 "kernels/dynamics/integrate_positions.cl.in"
// as in the template: 10
