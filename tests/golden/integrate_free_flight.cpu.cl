// integrate_free_flight.DIMS2.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.GYRO0.GRAVITY0.DRAG0.FORCES0.BOUNDARY0.ORDER1.WG1.PER_ITEM1024
#define DIMS 2
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
#define WG 1
#define PER_ITEM 1024
#define INTEGRATE_FREE_FLIGHT_ARGS \
    __global float4 *restrict centres, \
    __global float4 *restrict velocities, \
    float4 times, \
    uint substeps, \
    uint n
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/integrate_free_flight.cl.in"
// SPDX-License-Identifier: MIT
// Free flight: a whole step of each object, all substeps at once.
//
// ORDER 1 is semi-implicit Euler; 2 is the symmetric kick, drift, kick; 4 is
// three of those with Yoshida's times, the middle one backward.
//
//   times  a substep's length, and of ORDER 4 the outer and the inner part
//   drags  what of a velocity is left after each, or after half of it (ORDER > 1)
#line 20 "kernels/dynamics/integrate_free_flight.cl.in"

typedef struct {
    real4 centre;
    real4 velocity; // w: inverse mass
#line 25 "kernels/dynamics/integrate_free_flight.cl.in"
    real4 moved; // since the step began, as a solved step has it
#line 44 "kernels/dynamics/integrate_free_flight.cl.in"
} body;
#line 59 "kernels/dynamics/integrate_free_flight.cl.in"

#line 70 "kernels/dynamics/integrate_free_flight.cl.in"
static inline void move(body *b, real time)
{
#line 73 "kernels/dynamics/integrate_free_flight.cl.in"
    b->moved = add_scaled(b->moved, time, (real4)(b->velocity.xyz, 0));
#line 77 "kernels/dynamics/integrate_free_flight.cl.in"
}
#line 116 "kernels/dynamics/integrate_free_flight.cl.in"

static inline void advance(body *b,
#line 124 "kernels/dynamics/integrate_free_flight.cl.in"
                           real time)
{
#line 136 "kernels/dynamics/integrate_free_flight.cl.in"
    move(b, time);
#line 165 "kernels/dynamics/integrate_free_flight.cl.in"
}
#line 167 "kernels/dynamics/integrate_free_flight.cl.in"

static inline void arrive(body *b)
{
    b->centre.xyz += b->moved.xyz;
#line 174 "kernels/dynamics/integrate_free_flight.cl.in"
}
#line 200 "kernels/dynamics/integrate_free_flight.cl.in"

__kernel void integrate_free_flight(INTEGRATE_FREE_FLIGHT_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        body b;
        b.centre = centres[id];
        b.velocity = velocities[id];
#line 210 "kernels/dynamics/integrate_free_flight.cl.in"
        b.moved = (real4)(0);
#line 233 "kernels/dynamics/integrate_free_flight.cl.in"
        for (uint k = 0; k < substeps; ++k) {
#line 236 "kernels/dynamics/integrate_free_flight.cl.in"
            advance(&b,
#line 243 "kernels/dynamics/integrate_free_flight.cl.in"
                    times.x);
#line 245 "kernels/dynamics/integrate_free_flight.cl.in"
        }
#line 247 "kernels/dynamics/integrate_free_flight.cl.in"
        arrive(&b);
#line 276 "kernels/dynamics/integrate_free_flight.cl.in"
        centres[id] = b.centre;
        velocities[id] = b.velocity;
#line 282 "kernels/dynamics/integrate_free_flight.cl.in"
    }
}
