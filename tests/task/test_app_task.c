// SPDX-License-Identifier: MIT
// A task in an application: its own numbers and arrays in, what plain C computes out, at any share.
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/task_files.h"
#include "support/test.h"

#include <sys/stat.h>

enum { N = 1003 };

static const double shares[] = {0, 0.001, 0.37, 0.5, 1};

enum { SHARES = sizeof shares / sizeof *shares };

// ---------------------------------------------------------------- tasks

static const char saxpy[] =
    "local p = parameters { n = 1003 }\n"
    "return { kernel = 'saxpy', items = p.n, args = { a = 2, x = { 'float', p.n, init = 'index', "
    "access = 'slice' }, y = { 'float', p.n, init = 1, access = 'in out slice' } } }\n";

static void write_saxpy(void)
{
    task_files_write(".", "saxpy", "float a\nconst float *x\nfloat *y\n",
                     "y[i] = a * x[i] + y[i];");
    test_write_file("saxpy.task.lua", saxpy);
}

static duet_task *open_task(const char *path, bool copies)
{
    duet_task_def def = duet_default_task_def();
    def.pair = open_copying(copies);
    def.path = path;
    duet_task *t = kept(duet_task_create(&def, ERR));
    test_give_back(def.pair); // the task holds it
    return t;
}

static duet_task *open_text(const char *text, bool copies)
{
    test_write_file("t.task.lua", text);
    return open_task("t.task.lua", copies);
}

static void set_task_share(duet_task *t, double share)
{
    duet_plan plan = *duet_task_get_plan(t);
    plan.share = (uint32_t)(share * DUET_SHARE_ONE);
    must(duet_task_set_plan(t, &plan, ERR));
}

static duet_task_result run(duet_task *t)
{
    duet_task_result result;
    must(duet_task_run(t, &result, ERR));
    assert_true(result.total_ms > 0 && result.n_stages > 0);
    return result;
}

static void set(duet_task *t, const char *name, const void *elements, uint64_t n)
{
    must(duet_task_set_array(t, name, elements, n, ERR));
}

static const void *get(duet_task *t, const char *name, uint64_t expected)
{
    uint64_t n = 0;
    const void *elements = must(duet_task_get_array(t, name, &n, ERR));
    assert_int_equal(n, expected);
    return elements;
}

// ---------------------------------------------------------------- runs

// Small whole numbers, which float adds and multiplies exactly.
static void fill(float x[N], float y[N])
{
    for (int i = 0; i < N; ++i) {
        x[i] = (float)(i * 7 % 101);
        y[i] = (float)(i % 13);
    }
}

static void saxpy_at_shares(bool copies)
{
    float x[N], y[N];
    duet_task *t = open_task("saxpy.task.lua", copies);
    for (int s = 0; s < SHARES; ++s) {
        fill(x, y);
        must(duet_task_set_number(t, "a", 3, ERR));
        set(t, "x", x, N);
        set(t, "y", y, N);
        set_task_share(t, shares[s]);
        for (int again = 1; again < 4; ++again) { // y goes on from what it was
            run(t);
            const float *got = get(t, "y", N);
            for (int i = 0; i < N; ++i)
                if (got[i] != y[i] + (float)again * 3 * x[i])
                    fail_msg("share %g, run %d: y[%d] is %g", shares[s], again, i, (double)got[i]);
        }
    }
}

TEST(an_application_brings_its_own_numbers)
{
    write_saxpy();
    saxpy_at_shares(false);
    saxpy_at_shares(true);
}

TEST(what_is_not_set_is_what_the_file_gives)
{
    write_saxpy();
    duet_task *t = open_task("saxpy.task.lua", false);
    run(t);
    const float *y = get(t, "y", N);
    for (int i = 0; i < N; ++i)
        assert_true(y[i] == 2.0f * (float)i + 1);
    assert_true(((const float *)get(t, "x", N))[2] == 2);
}

static void count_at_shares(bool copies)
{
    uint8_t x[N];
    duet_task *t = open_text("return { kernel = 'count', items = 1003, args = { x = { 'uchar', "
                             "1003, access = 'slice' }, bins = { 'uint', 16, access = 'sum' } } }",
                             copies);
    for (int s = 0; s < SHARES; ++s) {
        uint32_t right[16] = {0};
        for (int i = 0; i < N; ++i) {
            x[i] = (uint8_t)(i * i % (11 + s));
            ++right[x[i]];
        }
        set(t, "x", x, N);
        set_task_share(t, shares[s]);
        run(t);
        assert_memory_equal(get(t, "bins", 16), right, sizeof right);
    }
}

TEST(sums_begin_with_nothing_in_each_run)
{
    task_files_write(".", "count", "const uchar *x\nuint *bins\n", "atomic_inc(&bins[x[i]]);");
    count_at_shares(false);
    count_at_shares(true);
}

// An array that is sent once is sent again once it is set.
static void table_at_shares(bool copies)
{
    duet_task *t = open_text("return { kernel = 'pick', items = 1003, args = { table = { 'int2', "
                             "7, send = 'once' }, y = { 'int2', 1003, access = 'out slice' } } }",
                             copies);
    for (int s = 0; s < SHARES; ++s) {
        int32_t table[14];
        for (int i = 0; i < 14; ++i)
            table[i] = 100 * s + i;
        set(t, "table", table, 7);
        set_task_share(t, shares[s]);
        for (int again = 0; again < 2; ++again) {
            run(t);
            const int32_t *y = get(t, "y", N);
            for (int i = 0; i < 2 * N; ++i)
                assert_int_equal(y[i], table[i % 14]);
        }
    }
}

TEST(an_array_that_is_sent_once_is_sent_again_when_it_is_set)
{
    task_files_write(".", "pick", "const int2 *table\nint2 *y\n", "y[i] = table[i % 7];");
    table_at_shares(false);
    table_at_shares(true);
}

TEST(numbers_have_the_kernels_types)
{
    task_files_write(".", "types", "int i32\nuint u32\nlong i64\nulong u64\nfloat f\nlong *y\n",
                     "y[0] = i32; y[1] = u32; y[2] = i64; y[3] = (long)(u64 >> 1); y[4] = "
                     "(long)(f * 4.0f);");
    duet_task *t = open_text("return { kernel = 'types', items = 1, args = { i32 = 0, u32 = 0, i64 "
                             "= 0, u64 = 0, f = 0, y = { 'long', 5, access = 'out slice' } } }",
                             false);
    must(duet_task_set_number(t, "i32", -5, ERR));
    must(duet_task_set_integer(t, "u32", UINT32_MAX, ERR));
    must(duet_task_set_integer(t, "i64", INT64_MIN, ERR));
    must(duet_task_set_integer(t, "u64", INT64_MAX, ERR));
    must(duet_task_set_number(t, "f", 0.75, ERR));
    assert_false(duet_task_set_number(t, "u32", 0.5, NULL)); // stays what it was
    assert_false(duet_task_set_integer(t, "i32", INT64_C(1) << 31, NULL));
    run(t);
    const int64_t right[] = {-5, UINT32_MAX, INT64_MIN, INT64_MAX / 2, 3};
    assert_memory_equal(get(t, "y", 5), right, sizeof right);
}

// ---------------------------------------------------------------- what a task is

TEST(arguments_are_listed_by_name)
{
    write_saxpy();
    const duet_setting settings[] = {{"n", "12"}};
    duet_task_def def = duet_default_task_def();
    def.pair = open_copying(false);
    def.path = "saxpy.task.lua";
    def.settings = settings;
    def.n_settings = 1;
    duet_task *t = kept(duet_task_create(&def, ERR));
    assert_int_equal(duet_task_get_items(t), 12);
    const duet_task_arg *a = duet_task_get_arg(t, 0), *y = duet_task_get_arg(t, 2);
    assert_string_equal(a->name, "a");
    assert_string_equal(a->type, "");
    assert_int_equal(a->elements, 0);
    assert_string_equal(y->name, "y");
    assert_string_equal(y->type, "float");
    assert_string_equal(y->access, "in out slice");
    assert_int_equal(y->elements, 12);
    assert_int_equal(y->bytes, 4);
    assert_null(duet_task_get_arg(t, 3));
}

// Nothing says what is right here, and nothing is asked.
TEST(an_application_does_not_compute_what_is_right)
{
    write_saxpy();
    duet_task *t = open_text("return { kernel = 'saxpy', items = 5, args = { a = 2, x = { 'float', "
                             "5 }, y = { 'float', 5, access = 'in out slice' } }, reference = "
                             "function(v) error('called') end }",
                             false);
    run(t);
    must_fail(duet_task_file_load("t.task.lua", NULL, 0, ERR), DUET_STATUS_BAD_INPUT, "called");
}

TEST(kernels_lie_beside_the_task_file)
{
    assert_int_equal(mkdir("kernels", 0755), 0);
    task_files_write("kernels", "saxpy", "float a\nconst float *x\nfloat *y\n", "y[i] = 5;");
    test_write_file("kernels/saxpy.task.lua", saxpy);
    duet_task *t = open_task("kernels/saxpy.task.lua", false);
    run(t);
    assert_true(((const float *)get(t, "y", N))[N - 1] == 5);
}

TEST(a_plan_has_settings_and_one_that_cannot_be_changes_nothing)
{
    write_saxpy();
    duet_task *t = open_task("saxpy.task.lua", false);
    duet_plan plan = *duet_task_get_plan(t);
    assert_int_equal(plan.mode, DUET_MODE_OWN);
    strcpy(plan.variant_b, "auto saxpy.WG=16");
    plan.share = DUET_SHARE_ONE / 4;
    must(duet_task_set_plan(t, &plan, ERR));
    const duet_plan before = *duet_task_get_plan(t);
    assert_memory_equal(&before, &plan, sizeof plan);
    strcpy(plan.variant_b, "auto saxpy.WG=3");
    must_fail(duet_task_set_plan(t, &plan, ERR), DUET_STATUS_BAD_ARGUMENT, "WG=3");
    assert_memory_equal(duet_task_get_plan(t), &before, sizeof before);
    run(t);
    assert_true(((const float *)get(t, "y", N))[N - 1] == 2.0f * (N - 1) + 1);
}

// ---------------------------------------------------------------- what is refused

#define REFUSED(call, says) must_fail(call, DUET_STATUS_BAD_ARGUMENT, says)

TEST(a_wrong_argument_is_one_line)
{
    write_saxpy();
    task_files_write(".", "halve", "uint m\nconst int *x\nint *y\n", "y[i] = x[i] / (int)m;");
    duet_task *t = open_text("return { kernel = 'halve', items = 10, args = { m = 2, x = { 'int', "
                             "10, access = 'slice' }, y = { 'int', 10, access = 'out slice' } } }",
                             false);
    const int x[10] = {0};
    REFUSED(duet_task_set_number(t, "k", 1, ERR),
            "duet_task_set_number: k is no argument of task t; expected one as m");
    REFUSED(duet_task_set_number(t, "x", 1, ERR), "x is an array; expected a number");
    REFUSED(duet_task_set_number(t, "m", 0.5, ERR),
            "task t: m is 0.5; expected a number that uint holds");
    REFUSED(duet_task_set_integer(t, "m", -1, ERR), "m is -1; expected a number that uint holds");
    REFUSED(duet_task_set_array(t, "m", x, 1, ERR), "m is a number; expected an array");
    REFUSED(duet_task_set_array(t, "x", x, 9, ERR), "x has 9 elements of int; expected 10");
    REFUSED(duet_task_set_array(t, "y", x, 10, ERR),
            "y is only written, its access is out slice; expected an array that is read");
    REFUSED(duet_task_get_array(t, "z", NULL, ERR), "z is no argument of task t");
    duet_plan plan = *duet_task_get_plan(t);
    plan.share = DUET_SHARE_ONE + 1;
    REFUSED(duet_task_set_plan(t, &plan, ERR), "share is 65537 of 65536");
}

TEST(a_task_that_cannot_be_made_is_one_line)
{
    static const struct {
        const char *text;
        duet_status status;
        const char *says;
    } cases[] = {
        {"return 5", DUET_STATUS_BAD_INPUT, "a task file returns a table"},
        {"return { kernel = 'none', items = 1, args = { y = { 'int', 1, access = 'sum' } } }",
         DUET_STATUS_BAD_INPUT, "t.task.lua:1: kernel is 'none'; expected a kernel: there are "},
        {"return { kernel = 'saxpy', items = 1, args = { a = 1, x = { 'int', 1 }, y = { 'float', "
         "1, access = 'sum' } } }",
         DUET_STATUS_BAD_INPUT, "args.x is an array of int; the card of saxpy has 'float *'"},
        {"return { kernel = 'broken', items = 1, args = { y = { 'int', 1, access = 'sum' } } }",
         DUET_STATUS_BUILD_FAILED, "broken"},
    };
    write_saxpy();
    task_files_write(".", "broken", "int *y\n", "y[i] = ;");
    duet_task_def def = duet_default_task_def();
    def.pair = open_copying(false);
    def.path = "t.task.lua";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        test_write_file("t.task.lua", cases[i].text);
        must_fail(duet_task_create(&def, ERR), cases[i].status, cases[i].says);
    }
    def.path = "no.task.lua";
    must_fail(duet_task_create(&def, ERR), DUET_STATUS_NOT_FOUND, "no.task.lua");
    test_give_back(def.pair);
}

TEST_EACH(test_enter_folder, test_leaves_no_object)
