// bodies.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.GRAVITY0.DRAG0.FORCES0.SLEEP0.WG1.PER_ITEM1024
#define DIMS 2
#define DOUBLE 0
#define ORIGIN 0
#define ANGULAR_VELOCITY 0
#define GRAVITY 0
#define DRAG 0
#define FORCES 0
#define SLEEP 0
#define WG 1
#define PER_ITEM 1024
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
// SPDX-License-Identifier: MIT
// Bodies for the solver: gathered from the state before the substeps, velocities
// integrated in each, and written back with rest times at the end.
//
//   bodies [n + 6][BODY]  the last six are the walls
#line 21 "kernels/dynamics/bodies.cl.in"

__kernel void prepare_bodies(PREPARE_BODIES_ARGS)
{
#line 28 "kernels/dynamics/bodies.cl.in"
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n + 6);
    for (uint id = first; id < last; ++id) {
        __global float4 *body = bodies + (size_t)id * BODY;
        bool wall = id >= n;
        body[BODY_VELOCITY] = wall ? (float4)(0.0f) : convert_float4(velocities[wall ? 0 : id]);
        body[BODY_DELTA_POSITION] = body[BODY_WARM_IMPULSE] = (float4)(0.0f);
#line 59 "kernels/dynamics/bodies.cl.in"
    }
}

// Velocities of a substep: gravity, drag, what commands push with, and the warm-start
// impulses of the last one.
__kernel void integrate_velocities(INTEGRATE_VELOCITIES_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        __global float4 *body = bodies + (size_t)id * BODY;
        float4 velocity = body[BODY_VELOCITY];
        float inverse_mass = velocity.w;
        if (!(inverse_mass > 0.0f))
            continue;
#line 88 "kernels/dynamics/bodies.cl.in"
        body[BODY_VELOCITY].xyz = add_float(velocity, inverse_mass, body[BODY_WARM_IMPULSE]).xyz;
        body[BODY_WARM_IMPULSE] = (float4)(0.0f);
#line 105 "kernels/dynamics/bodies.cl.in"
    }
}

#line 119 "kernels/dynamics/bodies.cl.in"
__kernel void finalize_bodies(FINALIZE_BODIES_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        __global const float4 *body = bodies + (size_t)id * BODY;
#line 134 "kernels/dynamics/bodies.cl.in"
        float4 velocity = body[BODY_VELOCITY];
        real4 centre = centres[id];
        centre.xyz += convert_real4(body[BODY_DELTA_POSITION]).xyz;
#line 140 "kernels/dynamics/bodies.cl.in"
        centres[id] = centre;
        velocities[id].xyz = convert_real4(velocity).xyz;
        float fastest = dot_float(velocity, velocity);
#line 160 "kernels/dynamics/bodies.cl.in"
    }
}
