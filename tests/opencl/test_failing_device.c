// SPDX-License-Identifier: MIT
// Devices that fail in the middle of a frame: each call to OpenCL in turn is
// made to fail, as a lost device, a driver out of resources or a compiler would
// have it, and each write not to arrive. Each time the failure is one clear line, the world can be
// stepped again, and the other device alone finds the same pairs.
#define _GNU_SOURCE
#include "support/test.h"

#include "runtime/opencl/device_pair.h"

#include <dlfcn.h>
#include <stdatomic.h>

// ------------------------------------------------------------ calls that fail

typedef enum call {
    LAUNCH, // a kernel's
    READ,
    MAP,
    WRITE, // from here on only in a world's first step, in host memory
    FILL,
    CREATE, // a buffer's
    BUILD,
    ARRIVE, // written data's
    CALLS
} call;

static const struct {
    const char *name;
    cl_int code;        // that it fails with
    duet_status status; // the status for that code
} calls[CALLS] = {
    [LAUNCH] = {"clEnqueueNDRangeKernel", CL_OUT_OF_RESOURCES, DUET_STATUS_DEVICE_FAILED},
    [WRITE] = {"clEnqueueWriteBuffer", CL_DEVICE_NOT_AVAILABLE, DUET_STATUS_DEVICE_FAILED},
    [READ] = {"clEnqueueReadBuffer", CL_DEVICE_NOT_AVAILABLE, DUET_STATUS_DEVICE_FAILED},
    [MAP] = {"clEnqueueMapBuffer", CL_MAP_FAILURE, DUET_STATUS_DEVICE_FAILED},
    [FILL] = {"clEnqueueFillBuffer", CL_OUT_OF_HOST_MEMORY, DUET_STATUS_NO_MEMORY},
    [CREATE] = {"clCreateBuffer", CL_MEM_OBJECT_ALLOCATION_FAILURE, DUET_STATUS_NO_MEMORY},
    [BUILD] = {"clBuildProgram", CL_BUILD_PROGRAM_FAILURE, DUET_STATUS_BUILD_FAILED},
    [ARRIVE] = {"a write under way", CL_OUT_OF_RESOURCES, DUET_STATUS_DEVICE_FAILED},
};

static atomic_int left[CALLS]; // calls until one fails; below 0: none does
static atomic_int wide; // launches of more than a group along the first two axes, or an offset
static atomic_int launches, maps;
static _Atomic(cl_event) lost; // event of a write in whose place zeros arrive

static bool fails(call c)
{
    return atomic_load(&left[c]) >= 0 && atomic_fetch_sub(&left[c], 1) == 0;
}

// C has no cast from the pointer that dlsym gives to one to a function.
#define FIND_REAL(function)                           \
    __typeof__(&(function)) next;                     \
    void *const found_ = dlsym(RTLD_NEXT, #function); \
    memcpy(&next, &found_, sizeof next)

// The program's own definitions go before the loader's.
cl_int clEnqueueNDRangeKernel(cl_command_queue q, cl_kernel k, cl_uint dims, const size_t *offset,
                              const size_t *global, const size_t *local, cl_uint n,
                              const cl_event *wait, cl_event *event)
{
    FIND_REAL(clEnqueueNDRangeKernel);
    atomic_fetch_add(&launches, 1);
    atomic_fetch_add(&wide, dims < 3 || global[0] > local[0] || global[1] > 1 || offset);
    return fails(LAUNCH) ? calls[LAUNCH].code
                         : next(q, k, dims, offset, global, local, n, wait, event);
}

cl_int clEnqueueWriteBuffer(cl_command_queue q, cl_mem mem, cl_bool blocking, size_t at,
                            size_t bytes, const void *from, cl_uint n, const cl_event *wait,
                            cl_event *event)
{
    FIND_REAL(clEnqueueWriteBuffer);
    if (event && fails(ARRIVE)) {
        const cl_uint zero = 0;
        cl_int code = clEnqueueFillBuffer(q, mem, &zero, sizeof zero, at, bytes, n, wait, event);
        atomic_store(&lost, *event);
        return code;
    }
    return fails(WRITE) ? calls[WRITE].code
                        : next(q, mem, blocking, at, bytes, from, n, wait, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue q, cl_mem mem, cl_bool blocking, size_t at,
                           size_t bytes, void *to, cl_uint n, const cl_event *wait, cl_event *event)
{
    FIND_REAL(clEnqueueReadBuffer);
    return fails(READ) ? calls[READ].code : next(q, mem, blocking, at, bytes, to, n, wait, event);
}

void *clEnqueueMapBuffer(cl_command_queue q, cl_mem mem, cl_bool blocking, cl_map_flags flags,
                         size_t at, size_t bytes, cl_uint n, const cl_event *wait, cl_event *event,
                         cl_int *code)
{
    FIND_REAL(clEnqueueMapBuffer);
    atomic_fetch_add(&maps, 1);
    if (!fails(MAP))
        return next(q, mem, blocking, flags, at, bytes, n, wait, event, code);
    *code = calls[MAP].code;
    return NULL;
}

cl_int clEnqueueFillBuffer(cl_command_queue q, cl_mem mem, const void *pattern, size_t size,
                           size_t at, size_t bytes, cl_uint n, const cl_event *wait,
                           cl_event *event)
{
    FIND_REAL(clEnqueueFillBuffer);
    return fails(FILL) ? calls[FILL].code : next(q, mem, pattern, size, at, bytes, n, wait, event);
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host,
                      cl_int *code)
{
    FIND_REAL(clCreateBuffer);
    if (!fails(CREATE))
        return next(context, flags, bytes, host, code);
    *code = calls[CREATE].code;
    return NULL;
}

cl_int clBuildProgram(cl_program program, cl_uint n, const cl_device_id *devices,
                      const char *options, void(CL_CALLBACK *notify)(cl_program, void *),
                      void *data)
{
    FIND_REAL(clBuildProgram);
    if (!fails(BUILD))
        return next(program, n, devices, options, notify, data);
    if (strstr(options, "_OPENCL_H_")) // and so does the build with the driver's header
        atomic_store(&left[BUILD], 0);
    return calls[BUILD].code;
}

cl_int clGetEventInfo(cl_event event, cl_event_info what, size_t size, void *value, size_t *bytes)
{
    FIND_REAL(clGetEventInfo);
    cl_int code = next(event, what, size, value, bytes);
    if (event == atomic_load(&lost) && what == CL_EVENT_COMMAND_EXECUTION_STATUS)
        memcpy(value, &calls[ARRIVE].code, sizeof calls[ARRIVE].code);
    return code;
}

cl_int clReleaseEvent(cl_event event)
{
    FIND_REAL(clReleaseEvent);
    if (event == atomic_load(&lost))
        atomic_store(&lost, NULL);
    return next(event);
}

// ------------------------------------------------------------ a world

enum { N = 1000 }; // so dense that a first step makes more space for pairs

static duet_device_pair *devices;  // that keep what they built: many worlds, few kernels
static duet_device_pair *builders; // that build each time
static duet_pose poses[N];
static uint64_t right; // the pairs' hash

static duet_world *open_world(duet_device_pair *pair, duet_mode mode)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.plan = duet_default_plan(pair);
    def.plan.mode = mode;
    def.plan.share = DUET_SHARE_ONE / 2;
    duet_world *world = kept(duet_world_create(&def, ERR));
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    return world;
}

static void open_devices(void)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    for (int c = 0; c < CALLS; ++c)
        atomic_store(&left[c], -1);
    builders = kept(duet_device_pair_create(&def, ERR));
    def.cache_dir = "test_failing_device.cache";
    devices = kept(duet_device_pair_create(&def, ERR));
    rng r = rng_seed(test_seed());
    for (int i = 0; i < N; ++i)
        for (int k = 0; k < 4; ++k) {
            poses[i].rotation[k] = (float)rng_normal(&r);
            if (k < 3) {
                poses[i].centre[k] = (float)rng_between(&r, 0, 8);
                poses[i].half_extents[k] = 0.5f;
            }
        }
    duet_result result;
    duet_world *world = open_world(devices, DUET_MODE_OWN);
    must(duet_world_step(world, &result, ERR));
    right = duet_result_get_hash(&result);
    test_give_back(world);
}

// Else the driver's own way.
static void map_memory(bool always)
{
    for (int side = 0; side < 2; ++side) {
        device *d = &devices->devices[side];
        const uint32_t quirks = driver_quirks(&d->info);
        d->quirks = always ? quirks & ~(uint32_t)DRIVER_IN_PLACE : quirks;
    }
}

// ------------------------------------------------------------ facts

static void assert_clear(const duet_error *err, call c)
{
    if (err->status != calls[c].status)
        fail_msg("%s fails as %s: %s", calls[c].name, duet_status_name(err->status), err->text);
    assert_true(strlen(err->text) > 0 && !strchr(err->text, '\n'));
    assert_true(c == BUILD || err->cl_code == calls[c].code);
}

static void assert_right(duet_world *world, uint32_t share)
{
    duet_result result;
    duet_plan plan = *duet_world_get_plan(world);
    plan.share = share;
    must(duet_world_set_plan(world, &plan, ERR));
    must(duet_world_step(world, &result, ERR));
    assert_true(duet_result_get_hash(&result) == right);
}

// Memory that a driver does not lock is plain memory, and what the cache holds and a driver does
// not take is compiled.
static bool is_borne(call c)
{
    const device *d = &devices->devices[1];
    return (c == CREATE && !d->info.host_memory) ||
           (c == BUILD && !(d->quirks & DRIVER_KEEPS_KERNELS));
}

// Lets the k-th call of a step fail; false where the step has no such call.
static bool survives(duet_world *world, call c, int k)
{
    duet_error err = {0};
    duet_result result;
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    atomic_store(&left[c], k);
    bool ok = duet_world_step(world, &result, &err);
    bool reached = atomic_exchange(&left[c], -1) < 0;
    assert_true(ok == !reached || is_borne(c));
    if (!reached)
        return false;
    if (!ok)
        assert_clear(&err, c);
    assert_right(world, 0);                  // B alone
    assert_right(world, DUET_SHARE_ONE);     // A alone
    assert_right(world, DUET_SHARE_ONE / 2); // the failure left no trace
    return true;
}

static void fail_each(duet_mode mode, call first, call last)
{
    duet_world *world = open_world(devices, mode);
    assert_right(world, DUET_SHARE_ONE / 2);
    for (int c = first; c <= (int)last; ++c) {
        int k = 0;
        while (survives(world, (call)c, k))
            ++k;
        print_message("%s: %d %s\n", duet_mode_name(mode), k, calls[c].name);
    }
}

TEST(a_failing_command_is_told_and_the_next_step_is_right)
{
    map_memory(true);
    for (duet_mode mode = DUET_MODE_SHARED; mode <= DUET_MODE_SLAB; ++mode)
        fail_each(mode, LAUNCH, MAP);
    map_memory(false);
}

TEST(where_kernels_work_in_place_nothing_is_mapped)
{
    int before = atomic_load(&maps);
    fail_each(DUET_MODE_SHARED, LAUNCH, MAP);
    fail_each(DUET_MODE_SLAB, LAUNCH, MAP);
    const device *d = devices->devices;
    assert_int_equal(atomic_load(&maps) > before, !(d[0].quirks & d[1].quirks & DRIVER_IN_PLACE));
}

// Takes the CPU's parts for devices with memory of their own, which all is copied to and from.
static void copy_memory(bool on)
{
    static bool host[2];
    for (int side = 0; side < 2; ++side) {
        bool *is_host = &devices->devices[side].info.host_memory;
        if (on)
            host[side] = *is_host;
        *is_host = !on && host[side];
    }
}

TEST(so_it_is_where_everything_is_copied)
{
    copy_memory(true);
    fail_each(DUET_MODE_OWN, LAUNCH, WRITE);
    fail_each(DUET_MODE_SLAB, LAUNCH, WRITE);
    for (duet_mode mode = DUET_MODE_SHARED; mode <= DUET_MODE_SLAB; ++mode)
        fail_each(mode, ARRIVE, ARRIVE); // and is sent again
    copy_memory(false);
}

// Takes a sample of the many buffers and kernels. The host may write and fill its own memory
// itself.
TEST(a_failing_first_step_is_told_and_the_next_one_is_right)
{
    static const int strides[CALLS] = {[WRITE] = 1, [FILL] = 1, [CREATE] = 7, [BUILD] = 7};
    for (int c = WRITE; c <= BUILD; ++c) {
        bool reached = true;
        copy_memory(c == WRITE || c == FILL);
        for (int k = 0; reached; k += strides[c]) {
            duet_world *world = open_world(c == BUILD ? builders : devices, DUET_MODE_OWN);
            reached = survives(world, (call)c, k);
            assert_true(reached || k > 0);
        }
        copy_memory(false);
    }
}

TEST(a_test_of_pairs_survives_as_well)
{
    static const call used[] = {LAUNCH, READ, CREATE, MAP};
    uint8_t verdicts[N / 2];
    uint8_t again[N / 2];
    duet_pair_query_result result;
    duet_error err = {0};
    map_memory(true);
    duet_pair_query_def def = duet_default_pair_query_def();
    def.pair = devices;
    def.share = DUET_SHARE_ONE / 2;
    duet_pair_query *test = kept(duet_pair_query_create(&def, ERR));
    must(duet_pair_query_run(test, poses, N / 2, verdicts, NULL, &result, ERR));
    for (size_t i = 0; i < sizeof used / sizeof *used; ++i)
        for (int k = 0; k < 2; ++k) {
            atomic_store(&left[used[i]], k);
            bool ok = duet_pair_query_run(test, poses, N / 2, again, NULL, &result, &err);
            bool reached = atomic_exchange(&left[used[i]], -1) < 0;
            assert_true(reached || used[i] == MAP || used[i] == CREATE); // on shared memory only
            assert_true(ok == !reached || is_borne(used[i]));
            if (!ok)
                assert_clear(&err, used[i]);
            err = (duet_error){0};
            must(duet_pair_query_run(test, poses, N / 2, again, NULL, &result, ERR));
            assert_memory_equal(again, verdicts, sizeof verdicts);
        }
    test_give_back(test);
    map_memory(false);
}

// A kernel is then compiled once for all ranges (runtime/opencl/driver.h).
TEST(every_launch_of_a_pocl_cpu_has_one_width)
{
    assert_true(atomic_load(&launches) > 0);
    if (driver_quirks(&devices->devices[0].info) & driver_quirks(&devices->devices[1].info) &
        DRIVER_TWO_WIDTHS)
        assert_int_equal(atomic_load(&wide), 0);
    else
        assert_true(atomic_load(&wide) > 0);
}

TEST_BEGIN(open_devices)
