// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "lost/lost.h"

#include <dlfcn.h>
#include <stdatomic.h>
#include <string.h>

enum { FAILURE = CL_DEVICE_NOT_AVAILABLE };

static atomic_uint n_calls, n_failures, n_finishes, n_wrong_unmaps;
static atomic_uint first; // the call that fails; UINT32_MAX: none
static atomic_int how;
static _Atomic(const char *) failed; // the first call that did
static const device *devices;        // A, B

const char *lost_way_name(lost_way way)
{
    static const char *const names[LOST_WAYS] = {"for ever", "once", "A", "B"};
    return names[way];
}

void lost_know(const duet_device_pair *pair)
{
    devices = pair ? pair->devices : NULL;
}

void lost_begin(lost_way way, uint32_t k)
{
    atomic_store(&n_calls, 0);
    atomic_store(&n_failures, 0);
    atomic_store(&n_finishes, 0);
    atomic_store(&n_wrong_unmaps, 0);
    atomic_store(&how, (int)way);
    atomic_store(&first, k);
}

uint32_t lost_end(void)
{
    atomic_store(&first, UINT32_MAX);
    return atomic_load(&n_calls);
}

uint32_t lost_finishes(void)
{
    return atomic_load(&n_finishes);
}

uint32_t lost_wrong_unmaps(void)
{
    return atomic_load(&n_wrong_unmaps);
}

const char *lost_call(void)
{
    return atomic_load(&n_failures) > 0 ? atomic_load(&failed) : "none";
}

// The call's device, 0 or 1; -1: not known, which is as good as any.
static bool fails(int of, const char *call)
{
    uint32_t place = atomic_fetch_add(&n_calls, 1);
    uint32_t k = atomic_load(&first);
    lost_way way = (lost_way)atomic_load(&how);
    bool hit = k != UINT32_MAX && (way == LOST_ONCE ? place == k : place >= k);
    if (hit && (way == LOST_A || way == LOST_B))
        hit = of < 0 || of == (way == LOST_B);
    if (hit && atomic_fetch_add(&n_failures, 1) == 0)
        atomic_store(&failed, call);
    return hit;
}

static int of_queue(cl_command_queue queue)
{
    for (int i = 0; devices && i < 2; ++i)
        if (queue == devices[i].queue || queue == devices[i].beside)
            return i;
    return -1;
}

static int of_context(cl_context context)
{
    for (int i = 0; devices && i < 2; ++i)
        if (context == devices[i].context)
            return i;
    return -1;
}

static int of_kernel(cl_kernel kernel)
{
    cl_context context = NULL;
    clGetKernelInfo(kernel, CL_KERNEL_CONTEXT, sizeof context, &context, NULL);
    return of_context(context);
}

static int of_program(cl_program program)
{
    cl_context context = NULL;
    clGetProgramInfo(program, CL_PROGRAM_CONTEXT, sizeof context, &context, NULL);
    return of_context(context);
}

// C has no cast from the pointer that dlsym gives to one to a function.
#define REAL(function)                                \
    __typeof__(&(function)) real;                     \
    void *const found_ = dlsym(RTLD_NEXT, #function); \
    memcpy(&real, &found_, sizeof real)

static int of_event(cl_event event)
{
    REAL(clGetEventInfo);
    cl_command_queue queue = NULL;
    real(event, CL_EVENT_COMMAND_QUEUE, sizeof queue, &queue, NULL);
    return of_queue(queue);
}

// A call with a code, of what it is told of, and one that makes something and tells a code.
#define FAILS_OR(function, of, takes, passes)                        \
    cl_int function takes                                            \
    {                                                                \
        REAL(function);                                              \
        return fails(of, #function) ? (cl_int)FAILURE : real passes; \
    }
#define NULL_OR(type, function, of, takes, passes) \
    type function takes                            \
    {                                              \
        REAL(function);                            \
        if (!fails(of, #function))                 \
            return real passes;                    \
        *code = FAILURE;                           \
        return NULL;                               \
    }

// ------------------------------------------------------------ commands

FAILS_OR(clEnqueueNDRangeKernel, of_queue(q),
         (cl_command_queue q, cl_kernel k, cl_uint dims, const size_t *offset, const size_t *global,
          const size_t *local, cl_uint n, const cl_event *wait, cl_event *event),
         (q, k, dims, offset, global, local, n, wait, event))
FAILS_OR(clEnqueueWriteBuffer, of_queue(q),
         (cl_command_queue q, cl_mem mem, cl_bool blocking, size_t at, size_t bytes,
          const void *from, cl_uint n, const cl_event *wait, cl_event *event),
         (q, mem, blocking, at, bytes, from, n, wait, event))
FAILS_OR(clEnqueueReadBuffer, of_queue(q),
         (cl_command_queue q, cl_mem mem, cl_bool blocking, size_t at, size_t bytes, void *to,
          cl_uint n, const cl_event *wait, cl_event *event),
         (q, mem, blocking, at, bytes, to, n, wait, event))
NULL_OR(void *, clEnqueueMapBuffer, of_queue(q),
        (cl_command_queue q, cl_mem mem, cl_bool blocking, cl_map_flags flags, size_t at,
         size_t bytes, cl_uint n, const cl_event *wait, cl_event *event, cl_int *code),
        (q, mem, blocking, flags, at, bytes, n, wait, event, code))
FAILS_OR(clEnqueueFillBuffer, of_queue(q),
         (cl_command_queue q, cl_mem mem, const void *pattern, size_t size, size_t at, size_t bytes,
          cl_uint n, const cl_event *wait, cl_event *event),
         (q, mem, pattern, size, at, bytes, n, wait, event))
FAILS_OR(clFlush, of_queue(q), (cl_command_queue q), (q))

cl_int clEnqueueUnmapMemObject(cl_command_queue q, cl_mem mem, void *at, cl_uint n,
                               const cl_event *wait, cl_event *event)
{
    REAL(clEnqueueUnmapMemObject);
    cl_int code = real(q, mem, at, n, wait, event);
    atomic_fetch_add(&n_wrong_unmaps, code == CL_INVALID_VALUE);
    return fails(of_queue(q), __func__) ? FAILURE : code;
}

cl_int clFinish(cl_command_queue q)
{
    REAL(clFinish);
    cl_int code = real(q);
    atomic_fetch_add(&n_finishes, 1);
    return fails(of_queue(q), __func__) ? FAILURE : code;
}

// ------------------------------------------------------------ questions

// Who spins asks again and again: that is one call, so that lives are alike.
cl_int clGetEventInfo(cl_event event, cl_event_info what, size_t size, void *value, size_t *n)
{
    static _Thread_local cl_event asked;
    REAL(clGetEventInfo);
    bool again = event == asked;
    asked = event;
    return !again && fails(of_event(event), __func__) ? FAILURE : real(event, what, size, value, n);
}

FAILS_OR(clGetEventProfilingInfo, of_event(event),
         (cl_event event, cl_profiling_info what, size_t size, void *value, size_t *n),
         (event, what, size, value, n))

// ------------------------------------------------------------ objects

NULL_OR(cl_mem, clCreateBuffer, of_context(context),
        (cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *code),
        (context, flags, bytes, host, code))
NULL_OR(cl_program, clCreateProgramWithSource, of_context(context),
        (cl_context context, cl_uint n, const char **texts, const size_t *lengths, cl_int *code),
        (context, n, texts, lengths, code))
NULL_OR(cl_program, clCreateProgramWithBinary, of_context(context),
        (cl_context context, cl_uint n, const cl_device_id *ids, const size_t *lengths,
         const unsigned char **binaries, cl_int *states, cl_int *code),
        (context, n, ids, lengths, binaries, states, code))
FAILS_OR(clBuildProgram, of_program(program),
         (cl_program program, cl_uint n, const cl_device_id *ids, const char *options,
          void(CL_CALLBACK *notify)(cl_program, void *), void *data),
         (program, n, ids, options, notify, data))
NULL_OR(cl_kernel, clCreateKernel, of_program(program),
        (cl_program program, const char *name, cl_int *code), (program, name, code))
FAILS_OR(clSetKernelArg, of_kernel(kernel),
         (cl_kernel kernel, cl_uint i, size_t size, const void *value), (kernel, i, size, value))
NULL_OR(cl_context, clCreateContext, -1,
        (const cl_context_properties *properties, cl_uint n, const cl_device_id *ids,
         void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *data,
         cl_int *code),
        (properties, n, ids, notify, data, code))
NULL_OR(cl_command_queue, clCreateCommandQueue, of_context(context),
        (cl_context context, cl_device_id id, cl_command_queue_properties properties, cl_int *code),
        (context, id, properties, code))
FAILS_OR(clCreateSubDevices, -1,
         (cl_device_id id, const cl_device_partition_property *cuts, cl_uint n, cl_device_id *parts,
          cl_uint *n_parts),
         (id, cuts, n, parts, n_parts))
