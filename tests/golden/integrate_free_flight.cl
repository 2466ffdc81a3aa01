#ifndef GPU
// integrate_free_flight.DIMS2.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.GYRO0.GRAVITY0.DRAG0.FORCES0.BOUNDARY0.ORDER1.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// integrate_free_flight.DIMS3.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.GYRO0.GRAVITY0.DRAG0.FORCES0.BOUNDARY0.ORDER1.WG128.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ORIGIN 0
#define ROTATED 0
#define ANGULAR_VELOCITY 0
#define GYRO 0
#define GRAVITY 0
#define DRAG 0
#define FORCES 0
#define BOUNDARY 0
#define ORDER 1
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 128
#define PER_ITEM 1
#endif /* GPU */
#define INTEGRATE_FREE_FLIGHT_ARGS \
    __global float4 *restrict centres, \
    __global float4 *restrict velocities, \
    float4 times, \
    uint substeps, \
    uint n
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 8
#line 20 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 4
#line 25 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 44 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 59 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 70 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 2
#line 73 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 77 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 116 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 2
#line 124 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 2
#line 136 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 165 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 167 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 4
#line 174 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 200 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 9
#line 210 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 233 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 236 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 243 "kernels/dynamics/integrate_free_flight.cl.in"
                    times.x);
#line 245 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 247 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 1
#line 276 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 2
#line 282 "kernels/dynamics/integrate_free_flight.cl.in"
// as in the template: 2
