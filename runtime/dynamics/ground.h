// SPDX-License-Identifier: MIT
// The ground of a motion: a copy of the heights that its def was given, here and on B.
#ifndef RUNTIME_GROUND_H
#define RUNTIME_GROUND_H

#include "runtime/duet.h"
#include "runtime/opencl/launcher.h"
#include "runtime/opencl/timeline.h"

typedef struct motion_ground {
    duet_heights heights; // the copy
    float *values;        // of the copy; NULL: there is no ground
    buffer buffer;
    // arguments of kernels
    arg_real4 origin, spacing; // and one over the spacing
    cl_int4 size;
    cl_float4 surface; // friction, restitution, material
} motion_ground;

// Copies the heights of a def, which then has the copy. A def without them gets a ground that is
// nowhere, for kernels that know one.
bool ground_copy(motion_ground *ground, duet_motion_def *def, duet_error *err);
bool ground_send(motion_ground *ground, const device *d, duet_error *err);
void ground_close(motion_ground *ground);

#endif
