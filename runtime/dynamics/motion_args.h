// SPDX-License-Identifier: MIT
// Arguments of a launch, in order; the values live in the list.
#ifndef RUNTIME_MOTION_ARGS_H
#define RUNTIME_MOTION_ARGS_H

#include "runtime/dynamics/motion.h"

enum { ARGS_MOST = 28 };

typedef union arg_value {
    cl_uint u;
    cl_float f;
    cl_double d;
    cl_float4 f4;
    cl_int4 i4;
    cl_double4 d4;
} arg_value;

typedef struct motion_args {
    duet_motion *motion;
    kernel_arg at[ARGS_MOST];
    arg_value values[ARGS_MOST];
    uint32_t n;
} motion_args;

motion_args args_begin(duet_motion *m);
void args_buffer(motion_args *a, motion_buffer which);
// The buffer, where the motion has the effect.
void args_buffer_for(motion_args *a, uint32_t effect, motion_buffer which);
void args_uint(motion_args *a, uint32_t value);
void args_float(motion_args *a, double value);
void args_float4(motion_args *a, double x, double y, double z, double w);
// The buffer of cells, with an origin.
void args_cells(motion_args *a);
void args_int4(motion_args *a, cl_int4 value);
void args_real(motion_args *a, double value);
void args_real4(motion_args *a, double x, double y, double z, double w);

bool args_launch(motion_args *a, const char *stage, const kernel *k, uint64_t work,
                 duet_error *err);

#endif
