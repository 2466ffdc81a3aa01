// SPDX-License-Identifier: MIT
// A task that an application describes in C is the task that a file would have been, and needs
// none.
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/task_files.h"
#include "support/test.h"

#include "runtime/opencl/device_pair.h"
#include "runtime/task/task_launch.h"

enum { N = 1003, COUNT = 16 };

static const char card[] =
    "return { about = 'test', params = { { 'WG', values = { 1, 4, 16 }, about = 'group' } }, args "
    "= "
    "{ scale = [[\nulong first\nulong last\nfloat a\nconst float *x\nfloat *y\nuint *signs\n]] }, "
    "launch = function(p) return { group = p.WG, per_item = 1 } end }";

// y = a x + y, and how many of y are above 0 or not
static const char body[] =
    "__kernel void scale(SCALE_ARGS)\n{\n    ulong i = first + get_global_id(0);\n    if (i >= "
    "last)\n        return;\n    y[i] = a * x[i] + y[i];\n    atomic_inc(&signs[y[i] > "
    "0.0f]);\n}\n";

static const duet_kernel_text kernels[] = {{"scale", card, body}};

static float x[N], y[N], expected[N];
static uint32_t signs[COUNT];

static const duet_task_arg_def args[] = {
    {.name = "x", .type = "float", .elements = N, .access = "slice", .initial = x},
    {.name = "a", .number = 3},
    {.name = "signs", .type = "uint", .elements = COUNT, .access = "sum", .expected = signs},
    {.name = "y",
     .type = "float",
     .elements = N,
     .access = "in out slice",
     .initial = y,
     .expected = expected},
};

enum { ARGS = sizeof args / sizeof *args };

static void fill(void)
{
    memset(signs, 0, sizeof signs);
    for (int i = 0; i < N; ++i) {
        x[i] = (float)(i * 7 % 101 - 50);
        y[i] = (float)(i % 13);
        expected[i] = 3 * x[i] + y[i]; // small whole numbers, which float has exactly
        ++signs[expected[i] > 0];
    }
    test_enter_folder();
}

static duet_task_def make_def(void)
{
    duet_task_def def = duet_default_task_def();
    def.kernel = "scale";
    def.kernels = kernels;
    def.n_kernels = 1;
    def.args = args;
    def.n_args = ARGS;
    def.items = N;
    return def;
}

// ---------------------------------------------------------------- runs

static void expect_run(duet_task *t)
{
    duet_task_result r;
    must(duet_task_run(t, &r, ERR));
    assert_memory_equal(must(duet_task_get_array(t, "y", NULL, ERR)), expected, sizeof expected);
    assert_memory_equal(must(duet_task_get_array(t, "signs", NULL, ERR)), signs, sizeof signs);
}

TEST(a_program_without_files_runs_its_kernel)
{
    for (int copies = 0; copies < 2; ++copies)
        for (uint32_t share = 0; share <= 4; ++share) {
            duet_task_def def = make_def();
            def.pair = open_copying(copies);
            def.plan.share = DUET_SHARE_ONE / 4 * share;
            expect_run(kept(duet_task_create(&def, ERR)));
        }
    assert_int_equal(test_count_files(), 0);
}

TEST(a_def_is_copied)
{
    char name[] = "scale", card_of_ours[sizeof card], type[] = "float", access[] = "slice";
    duet_kernel_text kernel = {name, card_of_ours, body};
    duet_task_arg_def list[ARGS];
    strcpy(card_of_ours, card);
    memcpy(list, args, sizeof list);
    list[0].type = type;
    list[0].access = access;
    duet_task_def def = make_def();
    def.pair = open_copying(false);
    def.kernel = kernel.name;
    def.kernels = &kernel;
    def.args = list;
    duet_task *t = kept(duet_task_create(&def, ERR));
    memset(name, '?', sizeof name - 1);
    memset(card_of_ours, '?', sizeof card_of_ours - 1);
    memset(type, '?', sizeof type - 1);
    memset(access, '?', sizeof access - 1);
    memset(list, 0, sizeof list);
    memset(x, 0, sizeof x);
    memset(y, 0, sizeof y);
    expect_run(t);
    duet_plan plan = *duet_task_get_plan(t); // another variant is made of the card again
    strcpy(plan.variant_b, "auto scale.WG=4");
    must(duet_task_set_plan(t, &plan, ERR));
    assert_int_equal(duet_task_get_items(t), N);
    assert_string_equal(duet_task_get_arg(t, 2)->access, "slice");
}

// ---------------------------------------------------------------- what is right

static bool launch(const duet_task_def *def, duet_error *err)
{
    task_result r;
    const duet_plan plan = {.share = DUET_SHARE_ONE / 3, .variant_a = "auto", .variant_b = "auto"};
    task *t = kept(duet_task_file_create(def, ERR));
    task_launcher *l = task_launcher_open(t, open_copying(false), err);
    bool ok = l && task_launch(l, &plan, &r, err);
    task_launcher_close(l);
    return ok;
}

TEST(expected_values_are_what_a_launch_is_checked_with)
{
    duet_task_def def = make_def();
    must(launch(&def, ERR));
    expected[700] += 1;
    must_fail(launch(&def, ERR), DUET_STATUS_WRONG_RESULT, "item 700: y[700] is ");
    def.tolerance = 1;
    must(launch(&def, ERR));
}

// A second kernel says what is right, from a folder; it writes 1 more.
TEST(a_reference_is_another_kernel)
{
    duet_task_arg_def list[ARGS];
    task_files_write(".", "plain", "float a\nconst float *x\nfloat *y\nuint *signs\n",
                     "y[i] = a * x[i] + y[i] + 1.0f; atomic_inc(&signs[0]);");
    memcpy(list, args, sizeof list);
    for (uint32_t i = 0; i < ARGS; ++i)
        list[i].expected = NULL;
    duet_task_def def = make_def();
    def.args = list;
    must(launch(&def, ERR)); // by the kernel itself
    def.folder = ".";
    def.reference = "plain";
    must_fail(launch(&def, ERR), DUET_STATUS_WRONG_RESULT, "expected ");
}

// ---------------------------------------------------------------- the same as a file

static const char file[] =
    "return { kernel = 'scale', items = 1003, tolerance = 0.5, work = { 2, 3 }, key = { n = 7, "
    "bins = 64, "
    "kind = 'b' }, args = { a = 3, x = { 'float', 1003, access = 'slice', halo = 2 }, y = { "
    "'float', 1003, access = 'in out slice' }, signs = { 'uint', 16, access = 'sum' } } }";

TEST(a_def_means_what_a_file_does)
{
    const duet_setting key[] = {{"kind", "b"}, {"n", "7"}, {"bins", "64"}};
    duet_task_arg_def list[ARGS];
    char of_file[TASK_WORDS], of_def[TASK_WORDS];
    memcpy(list, args, sizeof list);
    list[0].halo = 2;
    duet_task_def def = make_def();
    def.args = list;
    def.tolerance = 0.5;
    def.work = 2;
    def.high = 3;
    def.key = key;
    def.n_key = 3;
    test_write_file("scale.task.lua", file);
    task *a = kept(duet_task_file_load("scale.task.lua", NULL, 0, ERR));
    task *b = kept(duet_task_file_create(&def, ERR));
    task_write_words(a, of_file);
    task_write_words(b, of_def);
    assert_string_equal(of_file, of_def);
    assert_int_equal(b->size, 7);
    assert_true(a->size == b->size && a->items == b->items && a->work == b->work &&
                a->wide == b->wide && a->tolerance == b->tolerance && a->n_args == b->n_args);
    for (uint32_t i = 0; i < a->n_args; ++i) {
        const task_arg *f = &a->args[i], *d = &b->args[i];
        assert_string_equal(f->name, d->name);
        assert_true(f->kind == d->kind && f->access == d->access && f->halo == d->halo &&
                    f->count == d->count && f->per_item == d->per_item && f->value == d->value);
    }
}

// So that what 'duet tune --task' measured of files holds for a program that carries their texts.
TEST(a_carried_kernel_has_the_hash_of_its_files)
{
    char of_files[65], of_texts[65];
    duet_task_def def = make_def();
    duet_device_pair *pair = open_copying(false);
    test_write_file("scale.lua", card);
    test_write_file("scale.cl", body);
    task *carried = kept(duet_task_file_create(&def, ERR));
    def.n_kernels = 0;
    def.folder = ".";
    task *in_folder = kept(duet_task_file_create(&def, ERR));
    must(task_kernel_hash(carried, pair, of_texts, ERR));
    must(task_kernel_hash(in_folder, pair, of_files, ERR));
    assert_string_equal(of_texts, of_files);
}

// ---------------------------------------------------------------- what is refused

static void expect_refused(const duet_task_def *def, const char *says)
{
    must_fail(duet_task_file_create(def, ERR), DUET_STATUS_BAD_ARGUMENT, says);
}

static void refuse_arg(duet_task_arg_def arg, const char *says)
{
    duet_task_arg_def list[ARGS + 1];
    memcpy(list, args, sizeof args);
    list[ARGS] = arg;
    duet_task_def def = make_def();
    def.args = list;
    def.n_args = ARGS + 1;
    expect_refused(&def, says);
}

TEST(a_wrong_argument_is_one_line)
{
    const int zeros[N] = {0};
    refuse_arg((duet_task_arg_def){.name = "x"}, "the task of kernel scale: args.x is there twice");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "real", .elements = 1},
               "args.z: the type is real");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int"},
               "args.z: [2] is 0; expected a number of elements");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = UINT64_MAX},
               "args.z: [2] is 9223372036854775807; expected a number of elements");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = 4, .access = "slices"},
               "args.z: access is 'slices'; expected one of all, slice");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = 4, .access = "slice"},
               "args.z: 4 elements for 1003 items");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = 4, .halo = 1},
               "args.z: a halo with access all");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = 4, .send = "twice"},
               "args.z: send is 'twice'");
    refuse_arg((duet_task_arg_def){.name = "z", .initial = zeros},
               "args.z has initial values; expected them of an array that is read");
    refuse_arg((duet_task_arg_def){.name = "z",
                                   .type = "int",
                                   .elements = 4,
                                   .access = "sum",
                                   .initial = zeros,
                                   .expected = zeros},
               "args.z has initial values");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = 4, .expected = zeros},
               "args.z has expected values; expected them of an array that is written");
    refuse_arg((duet_task_arg_def){.name = "z", .type = "int", .elements = 4, .access = "sum"},
               "args.z has no expected values, but others have");
}

TEST(a_wrong_def_is_one_line)
{
    const duet_setting bad[] = {{"bins", "6 4"}}, no_size[] = {{"n", "few"}};
    duet_task_def def = make_def();
    def.items = 0;
    expect_refused(&def, "the task of kernel scale: items is 0; expected a whole number");
    def = make_def();
    def.work = UINT64_MAX;
    expect_refused(&def, "work is 9223372036854775807");
    def = make_def();
    def.tolerance = -1;
    expect_refused(&def, "tolerance is -1");
    def = make_def();
    def.n_args = 2;
    expect_refused(&def, "args: no array is written");
    def = make_def();
    def.key = bad;
    def.n_key = 1;
    expect_refused(&def, "key: 'bins' is '6 4'");
    def.key = no_size;
    expect_refused(&def, "key: n is 'few'; expected a whole number");
    def = make_def();
    def.reference = "plain";
    expect_refused(&def, "there are a reference and expected values; expected one of them");
    duet_task_arg_def one[2] = {args[0], args[3]};
    one[1].expected = NULL;
    def = make_def();
    def.args = one;
    def.n_args = 2;
    def.reference = "right.bin";
    expect_refused(&def,
                   "reference is 'right.bin', but the task has no folder; expected a kernel's");
    def = make_def();
    def.kernel = "";
    expect_refused(&def, "kernel is missing or empty");
}

static void expect_none(duet_task_def *def, duet_status status, const char *says)
{
    def->pair = open_copying(false);
    must_fail(duet_task_create(def, ERR), status, says);
}

TEST(a_kernel_that_is_nowhere_or_wrong_is_one_line)
{
    const duet_kernel_text no_card = {"scale", "return 5", body};
    const duet_kernel_text no_text = {"scale", card, "__kernel void scale(SCALE_ARGS) { y = ; }"};
    const duet_kernel_text no_name = {"../scale", card, body};
    duet_task_def def = make_def();
    def.n_kernels = 0;
    expect_none(
        &def, DUET_STATUS_BAD_ARGUMENT,
        "task scale: neither its def nor the pair says where the kernel's card and text are");
    def.folder = "nowhere";
    expect_none(&def, DUET_STATUS_NOT_FOUND, "nowhere");
    def = make_def();
    def.kernels = &no_card;
    expect_none(&def, DUET_STATUS_BUILD_FAILED, "the card of scale");
    def.kernels = &no_text;
    expect_none(&def, DUET_STATUS_BUILD_FAILED, "kernels/scale.cl:1");
    def.kernels = &no_name;
    expect_none(&def, DUET_STATUS_BAD_ARGUMENT, "a kernel's name is '../scale'");
}

TEST_EACH(fill, test_leaves_no_object)
