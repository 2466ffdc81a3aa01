// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_args.h"

#include <assert.h>

motion_args args_begin(duet_motion *m)
{
    return (motion_args){.motion = m};
}

static arg_value *add(motion_args *a, size_t size)
{
    assert(a->n < ARGS_MOST);
    a->at[a->n].size = size;
    return &a->values[a->n++];
}

static void args_memory(motion_args *a, const buffer *b)
{
    assert(a->n < ARGS_MOST);
    a->at[a->n++] = (kernel_arg){sizeof b->mem, &b->mem};
}

void args_buffer(motion_args *a, motion_buffer which)
{
    args_memory(a, &a->motion->buffers[which]);
}

void args_buffer_for(motion_args *a, uint32_t effect, motion_buffer which)
{
    if (motion_has(a->motion, effect))
        args_buffer(a, which);
}

void args_uint(motion_args *a, uint32_t value)
{
    add(a, sizeof(cl_uint))->u = value;
}

void args_float(motion_args *a, double value)
{
    add(a, sizeof(cl_float))->f = (float)value;
}

void args_float4(motion_args *a, double x, double y, double z, double w)
{
    add(a, sizeof(cl_float4))->f4 = (cl_float4){{(float)x, (float)y, (float)z, (float)w}};
}

void args_cells(motion_args *a)
{
    if (a->motion->cells)
        args_buffer(a, CELLS);
}

void args_int4(motion_args *a, cl_int4 value)
{
    add(a, sizeof value)->i4 = value;
}

void args_real(motion_args *a, double value)
{
    if (a->motion->def.doubles)
        add(a, sizeof(cl_double))->d = value;
    else
        args_float(a, value);
}

void args_real4(motion_args *a, double x, double y, double z, double w)
{
    if (a->motion->def.doubles)
        add(a, sizeof(cl_double4))->d4 = (cl_double4){{x, y, z, w}};
    else
        args_float4(a, x, y, z, w);
}

// The values moved with the list, if it did: they are pointed to only here.
bool args_launch(motion_args *a, const char *stage, const kernel *k, uint64_t work, duet_error *err)
{
    for (uint32_t i = 0; i < a->n; ++i)
        if (!a->at[i].value)
            a->at[i].value = &a->values[i];
    return timeline_launch(&a->motion->times, stage, k, work, a->at, a->n, err);
}
