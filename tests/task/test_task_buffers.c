// SPDX-License-Identifier: MIT
// Arrays of a task in buffers of a program with OpenCL of its own: what plain C computes lies in
// the buffers after a run, whichever devices know their context.
#define _POSIX_C_SOURCE 200809L
#include "support/own_program.h"
#include "support/task_files.h"
#include "support/test.h"

#include "runtime/duet_opencl.h"
#include "runtime/opencl/device_pair.h"

enum { N = 1003, BINS = 16 };

static cl_context other_context; // of the same device

static void release_context(void *context)
{
    clReleaseContext(context);
}

static void open_program(void)
{
    own_program_open();
    other_context = clCreateContext(NULL, 1, &own.root, NULL, NULL, NULL);
    assert_non_null(other_context);
    test_keep(other_context, release_context);
    task_files_write(".", "blend",
                     "float a\nconst float *x\nconst float *w\nfloat *y\nfloat *z\n"
                     "uint *bins\n",
                     "y[i] = a * x[i] + w[i % 5]; z[i] += x[i]; atomic_inc(&bins[(uint)x[i] % "
                     "16]);");
    test_write_file("blend.task.lua",
                    "local n = 1003 return { kernel = 'blend', items = n, args = { a = 2, x = { "
                    "'float', n, access = 'slice' }, w = { 'float', 5 }, y = { 'float', n, access "
                    "= 'out slice' }, z = { 'float', n, access = 'in out slice' }, bins = { "
                    "'uint', 16, access = 'sum' } } }");
}

// ---------------------------------------------------------------- the program's buffers

typedef struct numbers {
    float x[N], w[5], y[N], z[N];
    cl_uint bins[BINS];
} numbers;

typedef struct buffers {
    cl_mem x, w, y, z, bins;
} buffers;

static buffers make_buffers(const numbers *n)
{
    return (buffers){.x = own_buffer(n->x, sizeof n->x, CL_MEM_READ_ONLY),
                     .w = own_buffer(n->w, sizeof n->w, CL_MEM_READ_ONLY),
                     .y = own_buffer(n->y, sizeof n->y, CL_MEM_READ_WRITE),
                     .z = own_buffer(n->z, sizeof n->z, CL_MEM_READ_WRITE),
                     .bins = own_buffer(n->bins, sizeof n->bins, CL_MEM_READ_WRITE)};
}

static void bind(duet_task *t, const buffers *b)
{
    must(duet_task_set_buffer(t, "x", b->x, 0, NULL, ERR));
    must(duet_task_set_buffer(t, "w", b->w, 0, NULL, ERR));
    must(duet_task_set_buffer(t, "y", b->y, 0, NULL, ERR));
    must(duet_task_set_buffer(t, "z", b->z, 0, NULL, ERR));
    must(duet_task_set_buffer(t, "bins", b->bins, 0, NULL, ERR));
}

// The task holds what it needs.
static void release(buffers *b)
{
    test_give_back(b->x);
    test_give_back(b->w);
    test_give_back(b->y);
    test_give_back(b->z);
    test_give_back(b->bins);
}

// ---------------------------------------------------------------- what is right

static void begin(numbers *n)
{
    for (int i = 0; i < N; ++i) {
        n->x[i] = (float)(i * 7 % 101);
        n->y[i] = -1;
        n->z[i] = (float)(i % 13);
    }
    for (int i = 0; i < 5; ++i)
        n->w[i] = (float)(10 * i);
    for (int i = 0; i < BINS; ++i)
        n->bins[i] = 77;
}

static void compute(numbers *n)
{
    memset(n->bins, 0, sizeof n->bins);
    for (int i = 0; i < N; ++i) {
        n->y[i] = 2 * n->x[i] + n->w[i % 5];
        n->z[i] += n->x[i];
        ++n->bins[(int)n->x[i] % BINS];
    }
}

static void expect_in_buffers(const buffers *b, const numbers *right)
{
    numbers found;
    own_read(0, b->y, found.y, sizeof found.y, NULL);
    own_read(0, b->z, found.z, sizeof found.z, NULL);
    own_read(0, b->bins, found.bins, sizeof found.bins, NULL);
    assert_memory_equal(found.y, right->y, sizeof found.y);
    assert_memory_equal(found.z, right->z, sizeof found.z);
    assert_memory_equal(found.bins, right->bins, sizeof found.bins);
}

static void expect_on_host(duet_task *t, const char *name, const void *right, size_t bytes)
{
    const void *found = must(duet_task_get_array(t, name, NULL, ERR));
    assert_memory_equal(found, right, bytes);
}

// ---------------------------------------------------------------- runs

static duet_task *open_task(duet_device_pair *pair)
{
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.path = "blend.task.lua";
    return must(duet_task_create(&def, ERR));
}

static void run_at(duet_task *t, double share)
{
    duet_task_result result;
    duet_plan plan = *duet_task_get_plan(t);
    plan.share = (uint32_t)(share * DUET_SHARE_ONE);
    must(duet_task_set_plan(t, &plan, ERR));
    must(duet_task_run(t, &result, ERR));
}

static void run_in_buffers(duet_device_pair *pair)
{
    static const double shares[] = {0, 0.31, 1};
    static numbers right;
    duet_task *t = open_task(pair);
    begin(&right);
    buffers b = make_buffers(&right);
    bind(t, &b);
    for (int s = 0; s < 3; ++s) {
        run_at(t, shares[s]);
        compute(&right);
        expect_in_buffers(&b, &right);
        expect_on_host(t, "y", right.y, sizeof right.y);
        expect_on_host(t, "z", right.z, sizeof right.z);
        expect_on_host(t, "x", right.x, sizeof right.x);
        expect_on_host(t, "bins", right.bins, sizeof right.bins);
    }
    assert_int_equal(own_references(b.z), 2);
    // from here on x and z are the host's
    must(duet_task_set_array(t, "z", right.z, N, ERR));
    must(duet_task_set_array(t, "x", right.x, N, ERR));
    assert_int_equal(own_references(b.z), 1);
    run_at(t, 0.31);
    compute(&right);
    expect_on_host(t, "z", right.z, sizeof right.z);
    duet_task_destroy(t);
    assert_int_equal(own_references(b.y), 1);
    release(&b);
}

static duet_device_pair *open_pair(const char *selector, cl_command_queue a, cl_command_queue b)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = def.b = selector;
    return kept(duet_device_pair_create_on_queues(&def, a, b, ERR));
}

static void run_on(const char *selector, cl_command_queue a, cl_command_queue b)
{
    for (int copies = 0; copies < 2; ++copies) {
        duet_device_pair *pair = open_pair(selector, a, b);
        for (int side = 0; side < 2; ++side)
            pair->devices[side].info.host_memory &= !copies;
        run_in_buffers(pair);
    }
}

TEST(both_devices_know_the_buffers)
{
    run_on(NULL, own.queues[0], own.queues[1]);
}

TEST(one_device_knows_the_buffers)
{
    const char *other = own.cut ? "cpu[2/2]" : "cpu";
    run_on(other, own.queues[0], NULL);
    run_on(other, NULL, own.queues[0]);
}

TEST(one_device_does_all)
{
    run_on(NULL, own.queues[0], NULL);
}

// The program fills x behind an event that it completes only later: a run waits for that.
TEST(a_run_waits_for_events)
{
    static numbers right;
    duet_device_pair *pair = open_pair(NULL, own.queues[0], own.queues[1]);
    duet_task *t = open_task(pair);
    begin(&right);
    buffers b = make_buffers(&right);
    bind(t, &b);
    const float nine = 9;
    cl_event filled = NULL;
    for (int i = 0; i < N; ++i)
        right.x[i] = nine;
    assert_int_equal(clEnqueueFillBuffer(own.queues[1], b.x, &nine, sizeof nine, 0, N * sizeof nine,
                                         0, NULL, &filled),
                     CL_SUCCESS);
    clFlush(own.queues[1]);
    must(duet_task_set_buffer(t, "x", b.x, 1, &filled, ERR));
    clReleaseEvent(filled);
    run_at(t, 0.5);
    compute(&right);
    expect_in_buffers(&b, &right);
    duet_task_destroy(t);
    release(&b);
}

// ---------------------------------------------------------------- what is refused

static void refused(duet_task *t, const char *name, cl_mem mem, cl_uint n, const char *says)
{
    must_fail(duet_task_set_buffer(t, name, mem, n, NULL, ERR), DUET_STATUS_BAD_ARGUMENT, says);
}

TEST(a_wrong_buffer_is_one_line)
{
    static const float zeros[N];
    duet_device_pair *pair = open_pair(NULL, own.queues[0], own.queues[1]);
    duet_task *t = open_task(pair);
    cl_mem small = own_buffer(zeros, sizeof zeros - 4, CL_MEM_READ_WRITE);
    cl_mem read_only = own_buffer(zeros, sizeof zeros, CL_MEM_READ_ONLY);
    cl_mem elsewhere = clCreateBuffer(other_context, CL_MEM_READ_WRITE, sizeof zeros, NULL, NULL);
    refused(t, "a", small, 0, "duet_task_set_buffer: a is a number; expected an array");
    refused(t, "x", NULL, 0, "duet_task_set_buffer: x is NULL");
    refused(t, "x", small, 0, "x has 4008 bytes; expected at least 4012");
    refused(t, "y", read_only, 0, "y cannot be written by devices");
    refused(t, "x", elsewhere, 0, "x is of another context");
    refused(t, "x", read_only, 1, "events is NULL");
    clReleaseMemObject(elsewhere);
    duet_task_destroy(t);
}

TEST_EACH(NULL, test_leaves_no_object)
TEST_BEGIN(open_program)
