// SPDX-License-Identifier: MIT
// The ground of a motion: a copy of the heights or the mesh that its def was given, here and on B.
#ifndef RUNTIME_GROUND_H
#define RUNTIME_GROUND_H

#include "runtime/duet.h"
#include "runtime/opencl/launcher.h"
#include "runtime/opencl/timeline.h"

typedef enum ground_buffer {
    GROUND_VALUES, // heights or vertices
    GROUND_TRIANGLES,
    GROUND_NODES,
    GROUND_BUFFERS
} ground_buffer;

typedef struct motion_ground {
    duet_heights heights; // the copy; without heights there are none
    duet_mesh mesh;       // likewise
    buffer buffers[GROUND_BUFFERS];
    // arguments of kernels
    arg_real4 origin, spacing; // and one over the spacing
    cl_int4 size;
    cl_float4 surface; // friction, restitution, material
    cl_uint carrier;   // the place of the body that carries a mesh with one
} motion_ground;

// Copies the ground of a def, which then has the copy. A def without one gets a ground that is
// nowhere, for kernels that know one.
bool ground_copy(motion_ground *ground, duet_motion_def *def, duet_error *err);
bool ground_send(motion_ground *ground, const device *d, duet_error *err);
void ground_close(motion_ground *ground);

bool ground_is_there(const motion_ground *ground);

// Lets a def have the copy.
void ground_show(const motion_ground *ground, duet_motion_def *def);

#endif
