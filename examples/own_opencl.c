// SPDX-License-Identifier: MIT
// A program that uses OpenCL itself: its kernel moves boxes in its buffer, Duet finds the pairs
// there and leaves them in a buffer, and another kernel counts each box's neighbours.
//
//     cc examples/own_opencl.c -o own_opencl $(pkg-config --cflags --libs duet) -lOpenCL
#define CL_TARGET_OPENCL_VERSION 120
#include <duet/duet.h>
#include <duet/duet_opencl.h>

#include <stdio.h>
#include <string.h>

enum { N = 4096, FRAMES = 30 };

// Rows of ten floats are duet_pose: centre, half extents, quaternion.
static const char *const text =
    "kernel void place(global float *poses, float t) {\n"
    "    uint i = get_global_id(0);\n"
    "    global float *p = poses + 10 * i;\n"
    "    p[0] = (float)(i % 16) + 0.4f * sin(t + (float)i);\n"
    "    p[1] = (float)(i / 16 % 16) + 0.4f * cos(t + (float)i);\n"
    "    p[2] = (float)(i / 256);\n"
    "    p[3] = p[4] = p[5] = 0.3f;\n"
    "    p[6] = p[7] = p[8] = 0.0f;\n"
    "    p[9] = 1.0f;\n"
    "}\n"
    "kernel void count(global const uint2 *pairs, global const ulong *n, global uint *met) {\n"
    "    for (ulong i = get_global_id(0); i < *n; i += get_global_size(0)) {\n"
    "        atomic_inc(&met[pairs[i].x]);\n"
    "        atomic_inc(&met[pairs[i].y]);\n"
    "    }\n"
    "}\n";

typedef struct program {
    cl_device_id device;
    cl_context context;
    cl_command_queue queue;
    cl_program built;
    cl_kernel place, count;
    cl_mem poses, pairs, n_pairs, met;
} program;

static bool open_program(program *p)
{
    cl_platform_id platform;
    cl_int code = CL_SUCCESS;
    memset(p, 0, sizeof *p);
    if (clGetPlatformIDs(1, &platform, NULL) != CL_SUCCESS ||
        clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &p->device, NULL) != CL_SUCCESS)
        return false;
    p->context = clCreateContext(NULL, 1, &p->device, NULL, NULL, &code);
    p->queue = clCreateCommandQueue(p->context, p->device, 0, &code);
    p->built = clCreateProgramWithSource(p->context, 1, (const char **)&text, NULL, &code);
    if (clBuildProgram(p->built, 1, &p->device, "", NULL, NULL) != CL_SUCCESS)
        return false;
    p->place = clCreateKernel(p->built, "place", &code);
    p->count = clCreateKernel(p->built, "count", &code);
    p->poses = clCreateBuffer(p->context, CL_MEM_READ_WRITE, N * sizeof(duet_pose), NULL, &code);
    p->pairs =
        clCreateBuffer(p->context, CL_MEM_READ_WRITE, 16 * N * sizeof(duet_pair), NULL, &code);
    p->n_pairs = clCreateBuffer(p->context, CL_MEM_READ_WRITE, sizeof(cl_ulong), NULL, &code);
    p->met = clCreateBuffer(p->context, CL_MEM_READ_WRITE, N * sizeof(cl_uint), NULL, &code);
    return code == CL_SUCCESS;
}

static void close_program(program *p)
{
    clReleaseMemObject(p->met);
    clReleaseMemObject(p->n_pairs);
    clReleaseMemObject(p->pairs);
    clReleaseMemObject(p->poses);
    clReleaseKernel(p->count);
    clReleaseKernel(p->place);
    clReleaseProgram(p->built);
    clReleaseCommandQueue(p->queue);
    clReleaseContext(p->context);
}

static void move_boxes(program *p, float t)
{
    const size_t n = N;
    clSetKernelArg(p->place, 0, sizeof p->poses, &p->poses);
    clSetKernelArg(p->place, 1, sizeof t, &t);
    clEnqueueNDRangeKernel(p->queue, p->place, 1, NULL, &n, NULL, 0, NULL, NULL);
}

// Runs once the pairs are there, which it does not wait for here. A step that fails leaves none.
static void count_neighbours(program *p, cl_event pairs_are_there)
{
    const size_t n = 256;
    const cl_uint zero = 0;
    clEnqueueFillBuffer(p->queue, p->met, &zero, sizeof zero, 0, N * sizeof zero, 0, NULL, NULL);
    clSetKernelArg(p->count, 0, sizeof p->pairs, &p->pairs);
    clSetKernelArg(p->count, 1, sizeof p->n_pairs, &p->n_pairs);
    clSetKernelArg(p->count, 2, sizeof p->met, &p->met);
    clEnqueueNDRangeKernel(p->queue, p->count, 1, NULL, &n, NULL, 1, &pairs_are_there, NULL);
    clFlush(p->queue);
}

// The objects' buffer is the caller's kernel's; the marker that Duet puts behind that kernel tells
// when it may be read.
static bool run_frame(program *p, duet_world *world, float t, duet_result *result, duet_error *err)
{
    cl_event done = NULL;
    move_boxes(p, t);
    if (!duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, p->poses, N, 0, NULL, err) ||
        !duet_world_step_begin_event(world, &done, err))
        return false;
    count_neighbours(p, done);
    // Here the program has time for other things.
    bool ok = duet_world_step_end(world, result, err);
    clFinish(p->queue);
    clReleaseEvent(done);
    return ok;
}

static bool run(program *p, duet_world *world, duet_error *err)
{
    static cl_uint met[N];
    duet_result result;
    bool ok = duet_world_leave_pairs(world, 1, p->pairs, p->n_pairs, err);
    memset(&result, 0, sizeof result);
    for (int frame = 0; ok && frame < FRAMES; ++frame)
        ok = run_frame(p, world, 0.1f * (float)frame, &result, err);
    if (!ok)
        return false;
    unsigned long long sum = 0;
    cl_uint most = 0;
    clEnqueueReadBuffer(p->queue, p->met, CL_TRUE, 0, sizeof met, met, 0, NULL, NULL);
    for (int i = 0; i < N; ++i) {
        sum += met[i];
        most = met[i] > most ? met[i] : most;
    }
    printf("%llu pairs; the kernel met each twice: %s; no box has more than %u neighbours\n",
           (unsigned long long)result.pairs, sum == 2 * result.pairs ? "yes" : "no", most);
    return true;
}

int main(void)
{
    program p;
    duet_error err;
    memset(&err, 0, sizeof err);
    if (!open_program(&p)) {
        fprintf(stderr, "own_opencl: no OpenCL device that works\n");
        return 1;
    }
    duet_device_pair_def devices = duet_default_device_pair_def();
    devices.a = devices.b = NULL; // one device, that of the queue
    duet_world_def def = duet_default_world_def();
    def.pair = duet_device_pair_create_on_queues(&devices, p.queue, NULL, &err);
    def.rotated = false;
    duet_world *world = def.pair ? duet_world_create(&def, &err) : NULL;
    bool ok = world && run(&p, world, &err);
    if (!ok)
        fprintf(stderr, "own_opencl: %s\n", err.text);
    duet_world_destroy(world);
    duet_device_pair_destroy(def.pair);
    close_program(&p);
    return ok ? 0 : 1;
}
