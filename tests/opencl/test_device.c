// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/kernel_args.h"
#include "support/test.h"

#include "runtime/opencl/device_list.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/program_build.h"
#include "runtime/opencl/thread_pool.h"
#include "runtime/opencl/timeline.h"

#include <pthread.h>
#include <stdatomic.h>

static duet_device_pair *open_two(const char *a, const char *b, duet_error *err)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = a;
    def.b = b;
    return duet_device_pair_create(&def, err);
}

static void expect_place(const char *message, const char *place, const char *rest)
{
    static const char source[] = "#line 1 \"kernels/common.clh\"\nfirst\n#line 7 \"kernels/a.cl\"\n"
                                 "seventh\neighth\n#line 1\nfirst again\n";
    char to[PROGRAM_PLACE];
    assert_string_equal(program_place_message(source, message, to), rest);
    assert_string_equal(to, place);
}

TEST(a_message_that_counts_all_lines_is_one_of_a_file)
{
    expect_place("<kernel>:2:5: error: x", "kernels/common.clh:1", ":5: error: x");
    expect_place("<kernel>:4:1: error: x", "kernels/a.cl:7", ":1: error: x");
    expect_place("<kernel>:5:1: error: x", "kernels/a.cl:8", ":1: error: x");
    expect_place("<kernel>:7:1: error: x", "kernels/a.cl:1", ":1: error: x");
    expect_place("<kernel>:1:1: error: x", "", "<kernel>:1:1: error: x"); // there is no file yet
    expect_place("<kernel>:0: error: x", "", "<kernel>:0: error: x");
    expect_place("<kernel>:99:1: error: x", "", "<kernel>:99:1: error: x");
    expect_place("kernels/a.cl:7:1: error: x", "", "kernels/a.cl:7:1: error: x");
    expect_place("", "", "");
}

TEST(an_error_is_told_before_the_warnings_around_it)
{
    static const char warns[] =
        "(): Warning: Function x is a kernel\nptxas fatal   : Unresolved extern function 'y'\n";
    assert_string_equal(program_first_error(warns), strstr(warns, "ptxas"));
    static const char fails[] =
        "a.cl:1:1: warning: fatal\na.cl:2:1: error: x\n2 errors generated.\n";
    assert_string_equal(program_first_error(fails), strstr(fails, "a.cl:2"));
    assert_string_equal(program_first_error("warning: x\n"), "warning: x\n");
}

static void refused(const char *selector, duet_status status, const char *says)
{
    must_fail(open_two(selector, selector, ERR), status, says);
}

TEST(every_listed_device_can_be_opened_by_its_selector)
{
    duet_device_list *list = must(duet_device_list_create(ERR));
    assert_true(duet_device_list_get_count(list) > 0);
    for (uint32_t i = 0; i < duet_device_list_get_count(list); ++i) {
        const duet_device_info *info = duet_device_list_get_info(list, i);
        assert_true(info->units > 0 && info->max_group > 0 && info->global_bytes > 0);
        duet_device_pair *pair = must(open_two(info->selector, info->selector, ERR));
        assert_string_equal(duet_device_pair_get_info(pair, 0)->selector, info->selector);
        assert_string_equal(duet_device_pair_get_info(pair, 1)->selector, info->selector);
        duet_device_pair_destroy(pair);
    }
    assert_null(duet_device_list_get_info(list, duet_device_list_get_count(list)));
    duet_device_list_destroy(list);
}

TEST(selectors_are_unique)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    assert_true(device_list_roots(&roots, &n, NULL));
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < i; ++j)
            assert_string_not_equal(roots[i].info.selector, roots[j].info.selector);
}

TEST(a_part_has_the_units_it_names)
{
    const duet_device_info *cpu = cuttable_cpu();
    for (uint32_t first = 0; first < cpu->units && first < 4; ++first) {
        for (uint32_t last = first; last < cpu->units && last < 4; ++last) {
            char selector[80];
            snprintf(selector, sizeof selector, "%s[%u-%u]", cpu->selector, first, last);
            device d;
            must(device_open(&d, selector, ERR));
            assert_int_equal(d.info.units, last - first + 1);
            assert_string_equal(d.info.selector, selector);
            assert_false(d.info.can_cut);
            device_close(&d);
        }
    }
}

static void check_contexts(const char *a, const char *b, bool is_one)
{
    duet_device_pair *pair = must(open_two(a, b, ERR));
    const device *opened = pair->devices;
    assert_true((opened[0].context == opened[1].context) == is_one);
    assert_ptr_not_equal(opened[0].queue, opened[1].queue);
    assert_ptr_not_equal(opened[0].queue, opened[0].beside);
    assert_int_equal(device_live_objects(), 2 * 4);
    duet_device_pair_destroy(pair);
}

TEST(devices_have_contexts_of_their_own_and_one_that_is_both_has_one)
{
    const duet_device_info *cpu = cuttable_cpu();
    char first[96], last[96];
    snprintf(first, sizeof first, "%s[1/2]", cpu->selector);
    snprintf(last, sizeof last, "%s[2/2]", cpu->selector);
    check_contexts(first, last, false);
    check_contexts(first, first, false);
    check_contexts(cpu->selector, cpu->selector, true);
}

// A folder that nobody named holds what drivers do not keep themselves, as PoCL does.
TEST(without_a_folder_the_users_cache_is_taken)
{
    unsetenv("DUET_CACHE");
    setenv("XDG_CACHE_HOME", "/proc/nowhere", 1);
    duet_device_pair *pair = kept(open_two("pocl:0", "pocl:0", ERR));
    unsetenv("XDG_CACHE_HOME");
    assert_string_equal(pair->cache_dir, "/proc/nowhere/duet");
    duet_device_info other = pair->devices[0].info;
    assert_false(program_builder_keeps(&pair->builder, &other));
    must(duet_device_pair_check_cache(pair, ERR));
    strcpy(other.platform, "Intel(R) OpenCL");
    assert_true(program_builder_keeps(&pair->builder, &other));
    const duet_device_info own = pair->devices[1].info;
    pair->devices[1].info = other;
    must_fail(duet_device_pair_check_cache(pair, ERR), DUET_STATUS_BAD_ARGUMENT,
              "built kernels cannot be kept in /proc/nowhere/duet: ");
    pair->devices[1].info = own;
}

// With a GPU the pair is a CPU and the GPU; else one CPU is both, and B has all.
TEST(without_selectors_a_whole_machine_is_chosen)
{
    duet_device_pair *pair = kept(open_two(NULL, NULL, ERR));
    const device *a = &pair->devices[0];
    const device *b = &pair->devices[1];
    assert_int_equal(a->info.kind, DUET_KIND_CPU);
    assert_false(strchr(a->info.selector, '[') || strchr(b->info.selector, '['));
    assert_int_equal(duet_device_pair_is_one(pair), b->info.kind == DUET_KIND_CPU);
    assert_int_equal(duet_default_plan(pair).share, 0);
}

TEST(halves_hold_all_units_between_them)
{
    const duet_device_info *cpu = cuttable_cpu();
    duet_device_pair *pair = kept(open_two("halves", NULL, ERR));
    const duet_device_info *a = duet_device_pair_get_info(pair, 0);
    const duet_device_info *b = duet_device_pair_get_info(pair, 1);
    assert_int_equal(a->units + b->units, cpu->units);
    duet_plan plan = duet_default_plan(pair);
    assert_int_equal(plan.share, DUET_SHARE_ONE * (uint64_t)a->units / cpu->units);
    assert_int_equal(plan.mode, DUET_MODE_DEFAULT);
    duet_device_pair *same = kept(open_two("cpu[1/2],cpu[2/2]", NULL, ERR));
    assert_string_equal(duet_device_pair_get_info(same, 0)->selector, a->selector);
    assert_string_equal(duet_device_pair_get_info(same, 1)->selector, b->selector);
}

TEST(one_selector_is_a_pair_of_one)
{
    duet_device_pair *pair = must(open_two("cpu", NULL, ERR));
    assert_true(duet_device_pair_is_one(pair));
    assert_int_equal(duet_default_plan(pair).share, 0);
    duet_device_pair *opened = must(duet_device_pair_open("cpu", ERR));
    assert_true(duet_device_pair_is_one(opened));
    assert_string_equal(duet_device_pair_get_info(opened, 0)->selector,
                        duet_device_pair_get_info(pair, 0)->selector);
    duet_device_pair_destroy(opened);
    duet_device_pair_destroy(pair);
    must_fail(duet_device_pair_open("cpu,nowhere", ERR), DUET_STATUS_BAD_ARGUMENT, "");
}

// The k-th of n equal parts: they follow each other, and the last ends with the device.
TEST(equal_parts_are_cut_one_after_the_other)
{
    const duet_device_info *cpu = cuttable_cpu();
    uint32_t sum = 0;
    for (uint32_t k = 1; k <= cpu->units && cpu->units <= 8; ++k) {
        char selector[96], expected[96];
        device d;
        snprintf(selector, sizeof selector, "%s[%u/%u]", cpu->selector, k, cpu->units);
        snprintf(expected, sizeof expected, "%s[%u-%u]", cpu->selector, k - 1, k - 1);
        must(device_open(&d, selector, ERR));
        assert_string_equal(d.info.selector, expected);
        sum += d.info.units;
        device_close(&d);
    }
    assert_true(sum == cpu->units || cpu->units > 8);
    refused("cpu[0/2]", DUET_STATUS_BAD_ARGUMENT, "1 <= k <= n");
    refused("cpu[3/2]", DUET_STATUS_BAD_ARGUMENT, "1 <= k <= n");
    refused("cpu[1/0]", DUET_STATUS_BAD_ARGUMENT, "1 <= k <= n");
    refused("cpu[1/999999]", DUET_STATUS_BAD_ARGUMENT, "1 <= k <= n");
    refused("cpu[1/2]x", DUET_STATUS_BAD_ARGUMENT, "1 <= k <= n");
}

TEST(an_unknown_selector_is_answered_with_those_there_are)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    assert_true(device_list_roots(&roots, &n, NULL));
    refused("abacus:0", DUET_STATUS_BAD_ARGUMENT, "no device 'abacus:0'");
    refused("abacus:0", DUET_STATUS_BAD_ARGUMENT, roots[0].info.selector);
    refused("", DUET_STATUS_BAD_ARGUMENT, "no device ''");
    refused("[0-0]", DUET_STATUS_BAD_ARGUMENT, roots[0].info.selector);
}

TEST(a_part_out_of_range_is_refused_with_the_range)
{
    const duet_device_info *cpu = cuttable_cpu();
    const char *parts[] = {"[0-99999]", "[1-0]",  "[0]",  "[0-",   "[-1-0]",
                           "[]",        "[0-0]x", "[0-0", "[a-b]", "[4294967296-4294967297]"};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        char selector[120];
        snprintf(selector, sizeof selector, "%s%s", cpu->selector, parts[i]);
        refused(selector, DUET_STATUS_BAD_ARGUMENT, "0 <= first <= last <=");
    }
}

TEST(a_part_of_what_cannot_be_cut_is_refused)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    assert_true(device_list_roots(&roots, &n, NULL));
    for (uint32_t i = 0; i < n; ++i) {
        if (roots[i].info.can_cut)
            continue;
        char selector[80];
        snprintf(selector, sizeof selector, "%s[0-0]", roots[i].info.selector);
        refused(selector, DUET_STATUS_BAD_ARGUMENT, "cannot be cut");
        return;
    }
    print_message("every device here can be cut\n");
    skip();
}

TEST(a_failed_second_device_gives_the_first_back)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    assert_true(device_list_roots(&roots, &n, NULL));
    must_fail(open_two(roots[0].info.selector, "abacus:0", ERR), DUET_STATUS_BAD_ARGUMENT, "");
}

TEST(half_a_pair_and_a_def_without_defaults_are_refused)
{
    must_fail(open_two(NULL, "pocl:0", ERR), DUET_STATUS_BAD_ARGUMENT, "");
    static const char *const lists[] = {"", ",", "pocl:0,", ",pocl:0", "pocl:0,pocl:0,pocl:0"};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i)
        must_fail(open_two(lists[i], NULL, ERR), DUET_STATUS_BAD_ARGUMENT,
                  "expected two selectors");
    must_fail(duet_device_pair_create(&(duet_device_pair_def){0}, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_null(open_two("abacus:0", "abacus:0", NULL));
}

TEST(folders_come_from_the_environment_and_are_copied)
{
    char folder[] = "some/folder";
    setenv("DUET_KERNEL_DIR", folder, 1);
    setenv("DUET_CACHE", "off", 1);
    duet_device_pair *pair = kept(open_two(NULL, NULL, ERR));
    unsetenv("DUET_KERNEL_DIR");
    unsetenv("DUET_CACHE");
    assert_string_equal(pair->kernel_dir, "some/folder");
    assert_null(pair->cache_dir);
    must(duet_device_pair_check_cache(pair, ERR));
}

static void *open_and_close(void *failed)
{
    duet_error err = {0};
    duet_device_pair *pair = open_two(NULL, NULL, &err);
    *(bool *)failed = !pair;
    duet_device_pair_destroy(pair);
    return NULL;
}

// Comes first, so that its threads are the ones that ask OpenCL.
TEST(threads_may_open_pairs_together)
{
    pthread_t threads[4];
    bool failed[4];
    for (int i = 0; i < 4; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, open_and_close, &failed[i]), 0);
    for (int i = 0; i < 4; ++i) {
        pthread_join(threads[i], NULL);
        assert_false(failed[i]);
    }
}

// ------------------------------------------------------------ one program on two devices

TEST(pocls_cpus_are_known)
{
    static const struct {
        const char *platform, *version;
        duet_device_kind kind;
        bool third, in_place;
        uint32_t n_quirks;
    } cases[] = {
        {"Portable Computing Language", "PoCL HSTR: pthread-x86", DUET_KIND_CPU, true, true, 4},
        {"Portable Computing Language", "PoCL HSTR: cpu-x86", DUET_KIND_CPU, true, true, 4},
        {"Portable Computing Language", "PoCL HSTR: cpu-x86 HSTR: pocl-remote", DUET_KIND_CPU, true,
         false, 3},
        {"Portable Computing Language", "PoCL HSTR: CUDA", DUET_KIND_GPU, false, false, 2},
        {"NVIDIA CUDA", "OpenCL 3.0 CUDA", DUET_KIND_GPU, false, false, 0},
        {"Intel(R) OpenCL", "HSTR: cpu-x86", DUET_KIND_CPU, false, false, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        duet_device_info info = {.kind = cases[i].kind};
        strcpy(info.platform, cases[i].platform);
        strcpy(info.cl_version, cases[i].version);
        assert_int_equal((driver_quirks(&info) & DRIVER_TWO_WIDTHS) != 0, cases[i].third);
        assert_int_equal((driver_quirks(&info) & DRIVER_IN_PLACE) != 0, cases[i].in_place);
        uint32_t n = 0;
        for (const char *quirk; (quirk = duet_device_info_get_quirk(&info, n)); ++n)
            assert_says(quirk, ": Duet");
        assert_int_equal(n, cases[i].n_quirks);
    }
}

enum { CLEARED_MOST = 300000, CLEARINGS = 200 };

typedef struct clearing {
    device d;
    program_set *set;
    kernel *k;
    clear_args args;
    rng random;
    bool ok;
    duet_error err;
} clearing;

static void open_clearing(clearing *c, gen *g, const char *selector)
{
    static const gen_setting one = {"PER_ITEM", 1};
    must(device_open(&c->d, selector, ERR));
    c->set = must(program_set_open(&c->d, g, NULL, ERR));
    c->k = must(program_set_kernel(c->set, "clear", "clear", &one, 1, clear_bindings, ERR));
    must(program_set_build(c->set, ERR));
    size_t bytes = (CLEARED_MOST + 1) * sizeof(cl_uint);
    must(buffer_reserve(&c->args.counters, &c->d, sizeof(cl_uint), ERR));
    must(buffer_reserve(&c->args.counts, &c->d, bytes, ERR));
}

static void close_clearing(clearing *c)
{
    buffer_release(&c->args.counters);
    buffer_release(&c->args.counts);
    program_set_close(c->set);
    device_close(&c->d);
}

// Launches over ranges at random, each of which clears its words and no other.
static void *clear_ranges(void *arg)
{
    clearing *c = arg;
    timeline times = {0};
    cl_uint *words = test_alloc((CLEARED_MOST + 1) * sizeof *words);
    c->ok = words != NULL;
    for (int i = 0; c->ok && i < CLEARINGS; ++i) {
        uint32_t most = i % 2 ? CLEARED_MOST : 1000;
        cl_uint n = c->args.n_counts = 1 + rng_below(&c->random, most);
        timeline_begin(&times, &c->d, true);
        c->ok = timeline_fill(&times, "fill", &c->args.counts, 7, 0, n + 1, &c->err) &&
                timeline_launch(&times, "clear", c->k, n, &c->args, &c->err) &&
                timeline_read(&times, "read", &c->args.counts, words, (n + 1) * sizeof *words,
                              &c->err) &&
                timeline_finish(&times, &c->err) && words[n] == 7;
        for (cl_uint k = 0; c->ok && k < n; ++k)
            c->ok = words[k] == 0;
    }
    return NULL;
}

// PoCL below 6.0 aborted here, where launches of one program had ranges along the first axis.
TEST(two_devices_launch_one_program_over_any_ranges_at_once)
{
    uint64_t seed = test_seed();
    const duet_device_info *cpu = cuttable_cpu();
    gen *g = kept(gen_open(NULL, ERR));
    clearing c[2] = {{.random = rng_stream(seed, 0)}, {.random = rng_stream(seed, 1)}};
    for (int i = 0; i < 2; ++i)
        open_clearing(&c[i], g, cpu->selector);
    pthread_t other;
    assert_int_equal(pthread_create(&other, NULL, clear_ranges, &c[1]), 0);
    clear_ranges(&c[0]);
    pthread_join(other, NULL);
    for (int i = 0; i < 2; ++i) {
        if (!c[i].ok)
            fail_msg("%s", c[i].err.text);
        close_clearing(&c[i]);
    }
}

// Stages stay those of the step that had times, and no command has an event.
TEST(what_is_not_timed_is_done_all_the_same)
{
    const duet_device_info *cpu = cuttable_cpu();
    clearing c = {0};
    gen *g = kept(gen_open(NULL, ERR));
    open_clearing(&c, g, cpu->selector);
    timeline times = {0};
    timeline_begin(&times, &c.d, true);
    must(timeline_fill(&times, "fill", &c.args.counts, 7, 0, 1001, ERR));
    must(timeline_finish(&times, ERR));
    const duet_stage filled = times.stages[0];
    timeline_begin(&times, &c.d, false);
    c.args.n_counts = 1000;
    must(timeline_launch(&times, "clear", c.k, 1000, &c.args, ERR));
    assert_int_equal(times.n_launches, 1);
    assert_int_equal(times.n_events, 0);
    must(timeline_finish(&times, ERR));
    cl_uint words[1001] = {0};
    must(timeline_read(&times, "read", &c.args.counts, words, sizeof words, ERR));
    for (int k = 0; k < 1001; ++k)
        assert_int_equal(words[k], k < 1000 ? 0 : 7);
    must(timeline_finish(&times, ERR));
    assert_int_equal(times.n_stages, 1);
    assert_memory_equal(&times.stages[0], &filled, sizeof filled);
    close_clearing(&c);
}

// Work that nobody will wait for otherwise is over before its memory goes.
TEST(what_has_no_event_is_waited_for_when_it_is_forgotten)
{
    const duet_device_info *cpu = cuttable_cpu();
    clearing c = {0};
    gen *g = kept(gen_open(NULL, ERR));
    open_clearing(&c, g, cpu->selector);
    timeline times = {0};
    const cl_uint *words = c.args.counts.host;
    assert_non_null(words);
    c.args.n_counts = CLEARED_MOST;
    for (int i = 0; i < 10; ++i) {
        timeline_begin(&times, &c.d, false);
        for (cl_uint value = 1; value < 8; ++value)
            must(timeline_fill(&times, "fill", &c.args.counts, value, 0, CLEARED_MOST, ERR));
        must(timeline_launch(&times, "clear", c.k, CLEARED_MOST, &c.args, ERR));
        assert_int_equal(times.n_events, 0);
        timeline_clear(&times);
        assert_int_equal(words[CLEARED_MOST - 1], 0);
        assert_int_equal(words[0], 0);
    }
    close_clearing(&c);
}

// ------------------------------------------------------------ threads

enum { SHARED_THINGS = 100001 };

static void count_things(void *arg, uint64_t first, uint64_t last)
{
    for (uint64_t i = first; i < last; ++i)
        atomic_fetch_add((atomic_uchar *)arg + i, 1);
}

TEST(what_threads_share_is_done_once_each)
{
    static atomic_uchar done[SHARED_THINGS + 1];
    thread_pool *pool = must(thread_pool_open(3, ERR));
    for (uint64_t piece = 1; piece < 1000000; piece *= 10)
        thread_pool_share(pool, count_things, done, SHARED_THINGS, piece);
    thread_pool_share(NULL, count_things, done, SHARED_THINGS, 7);
    thread_pool_share(pool, count_things, done, 0, 7);
    for (int i = 0; i < SHARED_THINGS; ++i)
        assert_int_equal(done[i], 7);
    assert_int_equal(done[SHARED_THINGS], 0);
    thread_pool_close(pool);
    assert_true(thread_pool_spare(1) == 1 && thread_pool_spare(30) >= 1);
}

static void compile_declared(const device *d, gen *g, const char *name, uint64_t index)
{
    enum { MOST_PARAMS = 64 };
    gen_limits limits = program_limits(&d->info);
    const gen_param *params = NULL;
    uint32_t n_params = 0;
    gen_setting config[MOST_PARAMS];
    own(gen_variant) v;
    must(gen_params(g, name, &limits, &params, &n_params, ERR));
    assert_true(n_params <= MOST_PARAMS);
    must(gen_config(g, name, &limits, index, config, ERR));
    must(gen_make(g, name, config, n_params, &limits, &v, ERR));
    const char *sources[] = {gen_built_ins(g), v.text};
    char options[64];
    snprintf(options, sizeof options, "-cl-std=CL1.2 -w %s", driver_header_option);
    cl_program p = clCreateProgramWithSource(d->context, 2, sources, NULL, NULL);
    if (clCompileProgram(p, 1, &d->id, options, 0, NULL, NULL, NULL, NULL) != CL_SUCCESS)
        fail_msg("%s calls what kernels/built_ins.clh does not declare", v.name);
    clReleaseProgram(p);
}

// Takes the first config of each kernel and the last, which differ in every parameter.
TEST(every_built_in_function_that_a_kernel_calls_is_declared)
{
    duet_error err = {0};
    device d;
    const char *selector = cuttable_cpu()->selector; // skips where there is none
    gen *g = gen_open(NULL, &err);
    must(g && device_open(&d, selector, ERR));
    gen_limits limits = program_limits(&d.info);
    const char *name;
    for (uint32_t i = 0; (d.quirks & DRIVER_READS_HEADER) && (name = gen_kernel(g, i)); ++i) {
        uint64_t n = 0;
        must(gen_count(g, name, &limits, &n, ERR));
        compile_declared(&d, g, name, 0);
        compile_declared(&d, g, name, n - 1);
    }
    device_close(&d);
    gen_close(g);
}

TEST_EACH(NULL, test_leaves_no_object)
