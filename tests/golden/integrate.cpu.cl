// integrate.DIMS2.DOUBLE0.ROTATED0.SPIN0.GYRO0.GRAVITY0.DRAG0.BOUNDS0.ORDER1.WG1.PER_ITEM1024
#define DIMS 2
#define DOUBLE 0
#define ROTATED 0
#define SPIN 0
#define GYRO 0
#define GRAVITY 0
#define DRAG 0
#define BOUNDS 0
#define ORDER 1
#define WG 1
#define PER_ITEM 1024
#line 1 "kernels/common.clh"
#line 1 "kernels/motion.clh"
#line 1 "kernels/integrate.cl.in"
// SPDX-License-Identifier: MIT
// Free flight: a whole step of each object, all substeps at once.
//
// ORDER 1 is semi-implicit Euler; 2 is the symmetric kick, drift, kick; 4 is
// three of those with Yoshida's times, the middle one backward.
//
//   times  a substep's length, and of ORDER 4 the outer and the inner part
//   keeps  what of a velocity is left after each, or after half of it (ORDER > 1)
#line 26 "kernels/integrate.cl.in"

typedef struct {
    real4 centre;
    real4 velocity; // w: inverse mass
#line 38 "kernels/integrate.cl.in"
} body;
#line 47 "kernels/integrate.cl.in"

static inline void move(body *b, real time)
{
    b->centre = add_scaled(b->centre, time, (real4)(b->velocity.xyz, 0));
}
#line 77 "kernels/integrate.cl.in"

static inline void advance(body *b, real4 gravity, real time, real keep)
{
#line 87 "kernels/integrate.cl.in"
    move(b, time);
#line 110 "kernels/integrate.cl.in"
}
#line 135 "kernels/integrate.cl.in"

__kernel void integrate(__global real4 *restrict centres, __global real4 *restrict velocities,
#line 158 "kernels/integrate.cl.in"
                        real4 times, uint substeps, uint n)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        body b;
        b.centre = centres[id];
        b.velocity = velocities[id];
#line 176 "kernels/integrate.cl.in"
        const real4 gravity = (real4)(0);
#line 179 "kernels/integrate.cl.in"
        const real4 keeps = (real4)(1);
#line 181 "kernels/integrate.cl.in"
        for (uint k = 0; k < substeps; ++k) {
#line 186 "kernels/integrate.cl.in"
            advance(&b, gravity, times.x, keeps.x);
        }
#line 209 "kernels/integrate.cl.in"
        centres[id] = b.centre;
        velocities[id] = b.velocity;
#line 215 "kernels/integrate.cl.in"
    }
}
