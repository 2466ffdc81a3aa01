// SPDX-License-Identifier: MIT
#include "support/own_program.h"

#include "support/test.h"

own_program own;

// Fails if somebody else holds its queues.
static void close_program(void *nothing)
{
    (void)nothing;
    for (int i = 0; i < 2; ++i) {
        clFinish(own.queues[i]);
        assert_int_equal(own_queue_references(i), 1);
        clReleaseCommandQueue(own.queues[i]);
    }
    clReleaseContext(own.context);
    for (int i = 0; own.cut && i < 2; ++i)
        clReleaseDevice(own.ids[i]);
}

void own_program_open(void)
{
    const cl_device_partition_property halves[] = {CL_DEVICE_PARTITION_BY_COUNTS, 1, 1,
                                                   CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    cl_platform_id platform = NULL;
    cl_uint n = 0;
    assert_int_equal(clGetPlatformIDs(1, &platform, NULL), CL_SUCCESS);
    assert_int_equal(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &own.root, NULL), CL_SUCCESS);
    own.cut = clCreateSubDevices(own.root, halves, 2, own.ids, &n) == CL_SUCCESS && n == 2;
    if (!own.cut)
        own.ids[0] = own.ids[1] = own.root;
    own.context = clCreateContext(NULL, own.cut ? 2 : 1, own.ids, NULL, NULL, NULL);
    assert_non_null(own.context);
    for (int i = 0; i < 2; ++i) {
        own.queues[i] = clCreateCommandQueue(own.context, own.ids[i], 0, NULL);
        assert_non_null(own.queues[i]);
    }
    test_keep(&own, close_program);
}

static void release(void *mem)
{
    clReleaseMemObject(mem);
}

cl_mem own_buffer(const void *bytes, size_t size, cl_mem_flags flags)
{
    cl_int code = 0;
    cl_mem mem = clCreateBuffer(own.context, flags, size, NULL, &code);
    assert_int_equal(code, CL_SUCCESS);
    if (bytes)
        assert_int_equal(
            clEnqueueWriteBuffer(own.queues[0], mem, CL_TRUE, 0, size, bytes, 0, NULL, NULL),
            CL_SUCCESS);
    return test_keep(mem, release);
}

void own_read(int queue, cl_mem mem, void *to, size_t bytes, const cl_event *after)
{
    assert_int_equal(clEnqueueReadBuffer(own.queues[queue], mem, CL_TRUE, 0, bytes, to,
                                         after ? 1 : 0, after, NULL),
                     CL_SUCCESS);
}

cl_uint own_references(cl_mem mem)
{
    cl_uint n = 0;
    clGetMemObjectInfo(mem, CL_MEM_REFERENCE_COUNT, sizeof n, &n, NULL);
    return n;
}

cl_uint own_queue_references(int i)
{
    cl_uint n = 0;
    clGetCommandQueueInfo(own.queues[i], CL_QUEUE_REFERENCE_COUNT, sizeof n, &n, NULL);
    return n;
}
