// SPDX-License-Identifier: MIT
// Prefix sums on a device, beside those of plain C.
#define _DEFAULT_SOURCE
#include "support/test.h"

#include "runtime/opencl/device_list.h"
#include "runtime/opencl/scan.h"

#include <pthread.h>
#include <unistd.h>

enum { MOST = 300000, LARGEST = 3000000 };

// The host reads them here again once a timeline has shown them.
typedef struct bench {
    device d;
    gen *g;
    program_set *set;
    scan s;
    buffer words, sums;
    uint32_t from[LARGEST + 1];
} bench;

static bench b;

static bool ask_for_scan(const gen_offer *offers, uint32_t n, duet_error *err)
{
    const kernel_request list[] = {SCAN_KERNELS(&b.s, true)};
    return program_set_kernels(b.set, list, sizeof list / sizeof *list, offers, n, err);
}

// By a CPU that says to have more units than threads, so that parts are added up before they are
// told; or by blocks, as a GPU does.
static void open_bench(bool emptying, bool grouped)
{
    const device_root *roots = NULL;
    uint32_t n = 0, cpu = 0;
    device_list_roots(&roots, &n, NULL);
    while (cpu < n && !roots[cpu].info.host_memory)
        ++cpu;
    if (cpu == n)
        skip();
    const gen_offer offers[] = {{NULL, "EMPTIES", emptying, GEN_REQUIRED, NULL},
                                {NULL, "WG", grouped ? 64 : 1, GEN_REQUIRED, NULL},
                                {NULL, "PER_ITEM", grouped ? 4 : 8192, GEN_REQUIRED, NULL}};
    must(device_open(&b.d, roots[cpu].info.selector, ERR));
    b.d.info.units = 16;
    b.d.info.kind = grouped ? DUET_KIND_GPU : DUET_KIND_CPU;
    b.g = must(gen_open(NULL, ERR));
    b.set = must(program_set_open(&b.d, b.g, NULL, ERR));
    b.s.device = &b.d;
    must(ask_for_scan(offers, 3, ERR));
    must(program_set_build(b.set, ERR));
    must(buffer_reserve(&b.words, &b.d, sizeof b.from, ERR));
    must(buffer_reserve(&b.sums, &b.d, sizeof b.from, ERR));
}

static void close_bench(void)
{
    scan_close(&b.s);
    buffer_release(&b.words);
    buffer_release(&b.sums);
    program_set_close(b.set);
    gen_close(b.g);
    device_close(&b.d);
    assert_int_equal(device_live_objects(), 0);
}

// Word n is not to be touched.
static void try_scan(rng *r, uint32_t n, bool emptying)
{
    timeline t = {0};
    size_t bytes = (n + (size_t)1) * sizeof(uint32_t);
    buffer *const to = emptying ? &b.sums : &b.words;
    for (uint32_t i = 0; i <= n; ++i)
        b.from[i] = rng_below(r, 5);
    timeline_begin(&t, &b.d, true);
    must(timeline_write_at(&t, "send", &b.words, 0, b.from, bytes, ERR));
    must(timeline_fill(&t, "fill", &b.sums, 7, 0, n + (size_t)1, ERR));
    must(scan_run(&b.s, &t, "scan", &b.words, to, n, ERR));
    const buffer absent = {0}, *const list[] = {&absent, &b.words, &b.sums};
    uint32_t waits = t.n_waits;
    must(timeline_see(&t, "see", list, 3, ERR));
    assert_int_equal(t.n_waits, waits + 1);
    const uint32_t *words = b.words.host, *sums = to->host;
    uint32_t sum = 0;
    for (uint32_t i = 0; i < n; ++i) {
        assert_int_equal(sums[i], sum);
        sum += b.from[i];
        if (emptying)
            assert_int_equal(words[i], 0);
    }
    assert_int_equal(words[n], b.from[n]);
    assert_int_equal(((const uint32_t *)b.sums.host)[n], 7);
    must(timeline_finish(&t, ERR));
    assert_int_equal(t.n_events, 0);
}

static void try_numbers(rng *r, bool emptying, bool grouped)
{
    static const uint32_t numbers[] = {1, 3, 4, 255, 256, 257, 8191, 8192, 8193, 100001, MOST};
    open_bench(emptying, grouped);
    for (size_t i = 0; i < 4 * sizeof numbers / sizeof *numbers; ++i)
        try_scan(r, numbers[i % (sizeof numbers / sizeof *numbers)], emptying);
    close_bench();
}

// Sums are asked for, by more reads than wait in place, and words written and filled between
// launches: on some devices the host does that itself.
static void try_between(rng *r, timeline *t)
{
    enum { N = 5000, PARTS = TIMELINE_ASKED + 1 };
    static uint32_t sums[N];
    memset(sums, 0xff, sizeof sums);
    const uint32_t filled = rng_below(r, N), value = rng_below(r, 9), most = N - 1;
    uint32_t last = 0, sum = 0;
    for (uint32_t i = 0; i < N; ++i)
        b.from[i] = rng_below(r, 5);
    must(timeline_write_at(t, "send", &b.words, 0, b.from, N * sizeof *b.from, ERR));
    must(timeline_fill(t, "fill", &b.words, value, filled, N, ERR));
    must(scan_run(&b.s, t, "scan", &b.words, &b.words, N, ERR));
    for (uint32_t i = 0; i < PARTS; ++i)
        must(timeline_start_read(t, "see", &b.words, i * sizeof sums / PARTS, sums + i * N / PARTS,
                                 sizeof sums / PARTS, ERR));
    must(timeline_read_at(t, "see", &b.words, most * sizeof last, &last, sizeof last, ERR));
    for (uint32_t i = 0; i < N; ++i) {
        assert_int_equal(sums[i], sum);
        sum += i < filled ? b.from[i] : value;
    }
    assert_int_equal(last, sums[most]);
}

TEST(the_host_reads_writes_and_fills_between_launches)
{
    rng r = {test_seed()};
    timeline t = {0};
    uint32_t first = 0;
    open_bench(false, false);
    timeline_begin(&t, &b.d, true);
    for (int round = 0; round < 4; ++round)
        try_between(&r, &t);
    must(scan_run(&b.s, &t, "scan", &b.words, &b.words, 1, ERR));
    must(timeline_start_read(&t, "see", &b.words, 0, &first, sizeof first, ERR));
    first = 1;
    must(timeline_finish(&t, ERR));
    assert_int_equal(first, 0);
    close_bench();
}

// Memory of this size goes back to the system as soon as it is freed, and the next buffers get it.
enum { LARGE = 64 << 20, MARK = 0x55 };

static void expect_marks(const buffer *of)
{
    const unsigned char *bytes = of->host;
    size_t n = 0;
    while (n < of->bytes && bytes[n] == MARK)
        ++n;
    assert_int_equal(n, of->bytes);
}

// A buffer grows while a launch waits that writes to it: what then lies there is another's.
TEST(memory_is_kept_until_no_launch_uses_it)
{
    cl_int code = CL_SUCCESS;
    timeline t = {0};
    open_bench(false, false);
    timeline_begin(&t, &b.d, true);
    must(buffer_reserve(&b.words, &b.d, LARGE, ERR));
    for (uint32_t i = 0; i < MOST; ++i)
        ((uint32_t *)b.words.host)[i] = 1;
    cl_event gate = must(clCreateUserEvent(b.d.context, &code));
    must(timeline_follow(&t, gate, ERR));
    must(scan_run(&b.s, &t, "scan", &b.words, &b.words, MOST, ERR));
    must(timeline_flush(&t, ERR));
    must(buffer_reserve(&b.words, &b.d, 2 * (size_t)LARGE, ERR));
    must(buffer_reserve(&b.sums, &b.d, LARGE, ERR));
    memset(b.words.host, MARK, b.words.bytes);
    memset(b.sums.host, MARK, b.sums.bytes);
    assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
    must(timeline_finish(&t, ERR));
    expect_marks(&b.words);
    expect_marks(&b.sums);
    clReleaseEvent(gate);
    close_bench();
}

static void *open_gate(void *gate)
{
    usleep(100000);
    return clSetUserEventStatus(gate, CL_COMPLETE) == CL_SUCCESS ? gate : NULL;
}

// A block grows while a read waits that goes there, on either queue.
static void grow_block(cl_command_queue queue)
{
    cl_int code = CL_SUCCESS;
    host_block block = {0}, other = {0};
    pthread_t thread;
    void *opened = NULL;
    must(buffer_reserve(&b.words, &b.d, LARGE, ERR));
    memset(b.words.host, 0, LARGE);
    must(host_block_reserve(&block, &b.d, 1, LARGE, ERR));
    cl_event gate = must(clCreateUserEvent(b.d.context, &code));
    code = clEnqueueReadBuffer(queue, b.words.mem, CL_FALSE, 0, LARGE, block.bytes, 1, &gate, NULL);
    assert_int_equal(code, CL_SUCCESS);
    assert_int_equal(pthread_create(&thread, NULL, open_gate, gate), 0);
    must(host_block_reserve(&block, &b.d, 1, 2 * (size_t)LARGE, ERR));
    must(host_block_reserve(&other, &b.d, 1, LARGE, ERR));
    memset(block.bytes, MARK, block.size);
    memset(other.bytes, MARK, other.size);
    pthread_join(thread, &opened);
    assert_non_null(opened);
    clFinish(queue);
    expect_marks(&(buffer){.host = block.bytes, .bytes = block.size});
    expect_marks(&(buffer){.host = other.bytes, .bytes = other.size});
    clReleaseEvent(gate);
    host_block_release(&block);
    host_block_release(&other);
}

TEST(a_block_is_kept_until_nothing_is_read_into_it)
{
    open_bench(false, false);
    grow_block(b.d.queue);
    grow_block(b.d.beside);
    close_bench();
}

TEST(each_word_becomes_the_sum_of_those_before_it)
{
    rng r = {test_seed()};
    try_numbers(&r, false, false);
    try_numbers(&r, false, true);
}

TEST(sums_go_elsewhere_and_leave_zeros)
{
    rng r = {test_seed()};
    try_numbers(&r, true, false);
    try_numbers(&r, true, true);
}

// Words that were not zeroed may hold the next stamp.
TEST(stamps_begin_anew_after_new_words_were_not_zeroed)
{
    rng r = {test_seed()};
    timeline t = {0};
    open_bench(false, false);
    try_scan(&r, MOST, false);
    try_scan(&r, MOST, false);
    const cl_command_queue queue = b.d.queue;
    timeline_begin(&t, &b.d, true);
    must(scan_run(&b.s, &t, "scan", &b.words, &b.words, MOST, ERR));
    b.d.info.units = LARGEST;
    b.d.queue = NULL;
    must_fail(scan_run(&b.s, &t, "scan", &b.words, &b.words, LARGEST, ERR),
              DUET_STATUS_DEVICE_FAILED, "filling a buffer");
    b.d.queue = queue;
    timeline_finish(&t, NULL);
    try_scan(&r, LARGEST, false);
    assert_int_equal(b.s.stamp, 1);
    close_bench();
}

// Its caller closes it, or opens it again; nothing is left of what was there before.
TEST(a_scan_that_cannot_be_opened_has_no_kernels)
{
    open_bench(false, false);
    const gen_offer offer = {NULL, "NO_SUCH", 1, GEN_REQUIRED, NULL};
    must_fail(ask_for_scan(&offer, 1, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_null(b.s.block_sums);
    assert_null(b.s.top_sums);
    assert_null(b.s.blocks);
    assert_null(b.s.at_once);
    close_bench();
}
