// integrate_positions.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.GYRO0.FRICTION0.LANES8.BLOCK8.WG1.PER_ITEM1024
#define DIMS 2
#define DOUBLE 0
#define ANGULAR_VELOCITY 0
#define GYRO 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define LANES 8
#define BLOCK 8
#define WG 1
#define PER_ITEM 1024
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
// SPDX-License-Identifier: MIT
// Positions and rotations of the bodies after a substep. A body that neither moves nor
// turns keeps its bits.
//
//   bodies [n + 6][BODY]  the last six are the walls
#line 7 "kernels/dynamics/integrate_positions.cl.in"

__kernel void integrate_positions(INTEGRATE_POSITIONS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        __global float4 *body = bodies + (size_t)id * BODY;
        body[BODY_DELTA_POSITION].xyz = fma((float4)(h), body[BODY_VELOCITY], body[BODY_DELTA_POSITION]).xyz;
    }
}
