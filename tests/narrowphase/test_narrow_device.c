// SPDX-License-Identifier: MIT
// The narrow kernel by itself: pair by pair a device says what the
// specification in C says, whatever its compiler may fuse.
#include "support/test.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/promise.h"

#include "kernels/counters.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/program.h"
#include "support/narrow_float.h"

#define PLAIN "-cl-std=CL1.2"

enum { PAIRS = 3000, OBJECTS = 2 * PAIRS, LISTS = 2 };

typedef enum list { COLLIDING, UNDECIDED } list;

static gen *kernels;

static void begin(void)
{
    kernels = kept(gen_open(NULL, ERR));
}

static gen_variant make_narrow(const device *d, uint32_t dims)
{
    gen_variant made;
    gen_limits limits = program_limits(&d->info);
    const gen_setting settings[] = {{"DIMS", dims}, {"SORTED", 0}};
    must(gen_make(kernels, "narrow", settings, 2, &limits, &made, ERR));
    return made;
}

// NULL where it does not build.
static cl_program build(const device *d, const gen_variant *made, const char *options)
{
    const char *text = made->text;
    cl_program program = clCreateProgramWithSource(d->context, 1, &text, NULL, NULL);
    assert_non_null(program);
    if (clBuildProgram(program, 1, &d->id, options, NULL, NULL) == CL_SUCCESS)
        return program;
    clReleaseProgram(program);
    return NULL;
}

// ------------------------------------------------------------ a launch

typedef struct launch {
    cl_command_queue queue;
    cl_kernel kernel;
    cl_mem objects, candidates, found[LISTS], counters;
} launch;

static cl_mem buffer_of(const device *d, size_t bytes, void *content)
{
    cl_mem_flags from = content ? CL_MEM_COPY_HOST_PTR : 0;
    cl_mem mem = clCreateBuffer(d->context, CL_MEM_READ_WRITE | from, bytes, content, NULL);
    assert_non_null(mem);
    return mem;
}

static void set_arg(launch *l, cl_uint at, size_t bytes, const void *value)
{
    assert_int_equal(clSetKernelArg(l->kernel, at, bytes, value), CL_SUCCESS);
}

static void open_launch(launch *l, const device *d, cl_program program, duet_pose *poses)
{
    static duet_pair candidates[PAIRS];
    cl_uint counters[COUNTERS] = {[COUNT_CANDIDATES] = PAIRS};
    cl_uint capacity = PAIRS;
    for (uint32_t i = 0; i < PAIRS; ++i)
        candidates[i] = (duet_pair){2 * i, 2 * i + 1};
    l->queue = clCreateCommandQueue(d->context, d->id, 0, NULL);
    l->kernel = clCreateKernel(program, "narrow", NULL);
    assert_non_null(l->kernel);
    l->objects = buffer_of(d, OBJECTS * sizeof *poses, poses);
    l->candidates = buffer_of(d, sizeof candidates, candidates);
    l->counters = buffer_of(d, sizeof counters, counters);
    for (int i = 0; i < LISTS; ++i)
        l->found[i] = buffer_of(d, PAIRS * sizeof(duet_pair), NULL);
    set_arg(l, 0, sizeof(cl_mem), &l->objects);
    set_arg(l, 1, sizeof(cl_mem), &l->candidates);
    set_arg(l, 2, sizeof capacity, &capacity);
    for (cl_uint i = 0; i < LISTS; ++i) {
        set_arg(l, 3 + 2 * i, sizeof(cl_mem), &l->found[i]);
        set_arg(l, 4 + 2 * i, sizeof capacity, &capacity);
    }
    set_arg(l, 7, sizeof(cl_mem), &l->counters);
}

static void close_launch(launch *l)
{
    clReleaseMemObject(l->objects);
    clReleaseMemObject(l->candidates);
    clReleaseMemObject(l->counters);
    for (int i = 0; i < LISTS; ++i)
        clReleaseMemObject(l->found[i]);
    clReleaseKernel(l->kernel);
    clReleaseCommandQueue(l->queue);
}

static void read_list(launch *l, list which, uint32_t n, narrow_answer as,
                      narrow_answer answers[PAIRS])
{
    static duet_pair found[PAIRS];
    assert_in_range(n, 0, PAIRS);
    if (n == 0)
        return;
    assert_int_equal(clEnqueueReadBuffer(l->queue, l->found[which], CL_TRUE, 0, n * sizeof *found,
                                         found, 0, NULL, NULL),
                     CL_SUCCESS);
    for (uint32_t i = 0; i < n; ++i)
        answers[found[i].a / 2] = as;
}

// Asks a device about the pairs 0 1, 2 3, ...
static void run(const device *d, const gen_variant *made, cl_program program, duet_pose *poses,
                narrow_answer answers[PAIRS])
{
    launch l;
    cl_uint counts[COUNTERS];
    size_t group = made->group, tile = group * made->per_item;
    size_t items = (PAIRS + tile - 1) / tile * group;
    open_launch(&l, d, program, poses);
    assert_int_equal(
        clEnqueueNDRangeKernel(l.queue, l.kernel, 1, NULL, &items, &group, 0, NULL, NULL),
        CL_SUCCESS);
    assert_int_equal(
        clEnqueueReadBuffer(l.queue, l.counters, CL_TRUE, 0, sizeof counts, counts, 0, NULL, NULL),
        CL_SUCCESS);
    for (int i = 0; i < PAIRS; ++i)
        answers[i] = NARROW_SEPARATED;
    read_list(&l, COLLIDING, counts[COUNT_PAIRS], NARROW_COLLIDING, answers);
    read_list(&l, UNDECIDED, counts[COUNT_UNDECIDED], NARROW_UNDECIDED, answers);
    close_launch(&l);
}

// ------------------------------------------------------------ facts

static void fill_with_hard_pairs(duet_pose poses[OBJECTS], uint32_t dims)
{
    rng r = rng_seed(test_seed() + dims);
    const hard_class *c = hard_classes;
    for (int i = 0; i < PAIRS; ++i, ++c) {
        if (!c->name)
            c = hard_classes;
        hard_pair pair = c->make(&r, dims);
        poses[2 * i] = pair.a;
        poses[2 * i + 1] = pair.b;
    }
}

static void compare_with_specification(int side, uint32_t dims, const char *options)
{
    static duet_pose poses[OBJECTS];
    static narrow_answer answers[PAIRS];
    const device *d = &default_pair()->devices[side];
    fill_with_hard_pairs(poses, dims);
    own(gen_variant) made = make_narrow(d, dims);
    cl_program program = build(d, &made, options);
    assert_non_null(program);
    run(d, &made, program, poses, answers);
    clReleaseProgram(program);
    for (int i = 0; i < PAIRS; ++i) {
        hard_pair pair = {poses[2 * i], poses[2 * i + 1]};
        narrow_answer right = narrow_float(&pair.a, &pair.b, dims, true);
        if (answers[i] == right)
            continue;
        hard_pair_print(&pair, dims);
        fail_msg("%s with %s: answer %d; expected %d", d->info.selector, options, answers[i],
                 right);
    }
}

TEST(a_device_says_what_the_specification_says)
{
    for (int side = 0; side < 2; ++side)
        for (uint32_t dims = 2; dims <= 3; ++dims)
            compare_with_specification(side, dims, PLAIN);
}

TEST(fusing_products_and_sums_changes_no_answer)
{
    for (int side = 0; side < 2; ++side)
        for (uint32_t dims = 2; dims <= 3; ++dims)
            compare_with_specification(side, dims, PLAIN " -cl-mad-enable");
}

// ------------------------------------------------------------ all levels

static void ask_test_pairs(const device *d, cl_program program, const gen_variant *made,
                           duet_pose *poses, uint8_t answers[PAIRS])
{
    cl_uint n = PAIRS;
    size_t group = made->group, tile = group * made->per_item;
    size_t items = (PAIRS + tile - 1) / tile * group;
    launch l = {.queue = clCreateCommandQueue(d->context, d->id, 0, NULL),
                .kernel = clCreateKernel(program, "pair_query", NULL)};
    assert_non_null(l.kernel);
    cl_mem objects = buffer_of(d, OBJECTS * sizeof *poses, poses);
    cl_mem found = buffer_of(d, PAIRS, NULL);
    set_arg(&l, 0, sizeof objects, &objects);
    set_arg(&l, 1, sizeof n, &n);
    set_arg(&l, 2, sizeof found, &found);
    assert_int_equal(
        clEnqueueNDRangeKernel(l.queue, l.kernel, 1, NULL, &items, &group, 0, NULL, NULL),
        CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(l.queue, found, CL_TRUE, 0, PAIRS, answers, 0, NULL, NULL),
                     CL_SUCCESS);
    clReleaseMemObject(objects);
    clReleaseMemObject(found);
    clReleaseKernel(l.kernel);
    clReleaseCommandQueue(l.queue);
}

// The compiler may fuse and contract all it likes: beside the option the text
// loses the line that forbids it.
static void ask_level(const device *d, duet_level level, bool contracted, duet_pose *poses,
                      uint8_t answers[PAIRS])
{
    own(gen_variant) made;
    gen_limits limits = program_limits(&d->info);
    const gen_setting settings[] = {{"DIMS", 3}, {"ACCURACY", level}};
    must(gen_make(kernels, "pair_query", settings, 2, &limits, &made, ERR));
    char *off = strstr(made.text, "FP_CONTRACT OFF");
    assert_non_null(off);
    if (contracted)
        memcpy(off, "FP_CONTRACT ON ", strlen("FP_CONTRACT ON "));
    cl_program program = build(d, &made, contracted ? PLAIN " -cl-mad-enable" : PLAIN);
    assert_non_null(program);
    ask_test_pairs(d, program, &made, poses, answers);
    clReleaseProgram(program);
}

// A level is defined operation by operation, so contraction may change what it says of a pair, and
// does on NVIDIA's devices; but not beyond what the level promises.
TEST(contraction_breaks_no_promise_of_any_level)
{
    static duet_pose poses[OBJECTS];
    static uint8_t plain[PAIRS], contracted[PAIRS];
    const device *d = &default_pair()->devices[1];
    fill_with_hard_pairs(poses, 3);
    for (int l = 0; l < DUET_LEVELS; ++l) {
        const duet_level_info *info = duet_level_get_info((duet_level)l);
        ask_level(d, (duet_level)l, false, poses, plain);
        ask_level(d, (duet_level)l, true, poses, contracted);
        for (int i = 0; i < PAIRS; ++i) {
            hard_pair pair = {poses[2 * i], poses[2 * i + 1]};
            if (plain[i] == contracted[i] || contracted[i] == NARROW_UNDECIDED ||
                promise_allows(info->missed, info->added, &pair, 3, contracted[i]))
                continue;
            hard_pair_print(&pair, 3);
            fail_msg("level %s: %d, contracted %d", info->name, plain[i], contracted[i]);
        }
    }
}

TEST(relaxed_arithmetic_is_refused_by_every_kernel)
{
    const device *d = &default_pair()->devices[1];
    gen_limits limits = program_limits(&d->info);
    for (uint32_t i = 0; gen_kernel(kernels, i); ++i) {
        own(gen_variant) made;
        must(gen_make(kernels, gen_kernel(kernels, i), NULL, 0, &limits, &made, ERR));
        assert_null(build(d, &made, PLAIN " -cl-fast-relaxed-math"));
    }
}

TEST_BEGIN(begin)
