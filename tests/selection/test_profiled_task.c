// SPDX-License-Identifier: MIT
// A task as the profile store knows it: an application gets the plan that its kernel was tuned to.
#include "support/store.h"
#include "support/task_files.h"
#include "support/test.h"

#include "runtime/selection/profile_subject.h"

static const char task_text[] =
    "local p = parameters { n = 4000 }\n"
    "return { kernel = 'twice', items = p.n, key = { n = p.n }, args = { x "
    "= { 'int', p.n, init = 'index', access = 'slice' }, y = { 'int', p.n, "
    "access = 'out slice' } } }\n";

static duet_device_pair *pair;

static void open_pair(void)
{
    pair = kept(duet_device_pair_open(NULL, ERR));
}

static void begin(void)
{
    test_enter_folder();
    task_files_write(".", "twice", "const int *x\nint *y\n", "y[i] = 2 * x[i];");
    test_write_file("twice.task.lua", task_text);
}

static duet_task *create(const char *n)
{
    const duet_setting setting = {"n", n};
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.path = "twice.task.lua";
    def.settings = &setting;
    def.n_settings = 1;
    return kept(duet_task_create(&def, ERR));
}

// Stores a plan for n items, as a tuning does.
static void put(const char *n, double share, const char *variant)
{
    const duet_setting setting = {"n", n};
    profile_subject p;
    duet_task_file *file = kept(duet_task_file_load("twice.task.lua", &setting, 1, ERR));
    must(profile_subject_read_task(file, pair, &p, ERR));
    duet_plan plan = {.share = (uint32_t)(share * DUET_SHARE_ONE), .mode = DUET_MODE_OWN};
    strcpy(plan.variant_a, variant);
    strcpy(plan.variant_b, variant);
    profile_plan stored = profile_subject_write_plan(&plan, p.workload.level);
    test_store_plan("store.db", &p.pair, &p.workload, p.kernels, &stored);
}

static duet_profile load(duet_task *t)
{
    duet_profile profile;
    must(duet_task_load_profile(t, "store.db", &profile, ERR));
    assert_memory_equal(&profile.plan, duet_task_get_plan(t), sizeof profile.plan);
    return profile;
}

static void expect_twice(duet_task *t)
{
    duet_task_result result;
    uint64_t n = 0;
    must(duet_task_run(t, &result, ERR));
    const int *y = must(duet_task_get_array(t, "y", &n, ERR));
    for (uint64_t i = 0; i < n; ++i)
        assert_int_equal(y[i], 2 * i);
}

TEST(an_application_runs_by_the_plan_that_was_measured)
{
    put("4000", 0.25, "auto twice.WG=16");
    duet_task *t = create("4000");
    duet_profile found = load(t);
    assert_int_equal(found.grade, DUET_GRADE_EXACT);
    assert_int_equal(found.plan.share, DUET_SHARE_ONE / 4);
    assert_string_equal(found.plan.variant_b, "auto twice.WG=16");
    assert_string_equal(found.verdict, "faster");
    assert_true(found.step_ms == 2);
    expect_twice(t);
}

TEST(a_size_within_a_tenth_gets_the_same_plan)
{
    put("4000", 0.25, "auto twice.WG=16");
    duet_task *t = create("4100");
    duet_profile found = load(t);
    assert_int_equal(found.grade, DUET_GRADE_INTERPOLATED);
    assert_int_equal(found.plan.share, DUET_SHARE_ONE / 4);
    expect_twice(t);
}

// The files' texts are in the program.
TEST(a_program_without_files_gets_the_plan_of_its_files)
{
    enum { N = 4000 };
    static int x[N];
    char n[8];
    put("4000", 0.25, "auto twice.WG=16");
    text card = test_read_file("twice.lua"), body = test_read_file("twice.cl");
    for (int i = 0; i < N; ++i)
        x[i] = i;
    snprintf(n, sizeof n, "%d", N);
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.kernel = "twice";
    def.kernels = &(duet_kernel_text){"twice", card.chars, body.chars};
    def.n_kernels = 1;
    def.args = (duet_task_arg_def[]){
        {.name = "x", .type = "int", .elements = N, .access = "slice", .initial = x},
        {.name = "y", .type = "int", .elements = N, .access = "out slice"}};
    def.n_args = 2;
    def.items = N;
    def.key = &(duet_setting){"n", n};
    def.n_key = 1;
    duet_task *t = kept(duet_task_create(&def, ERR));
    duet_profile found = load(t);
    assert_int_equal(found.grade, DUET_GRADE_EXACT);
    assert_int_equal(found.plan.share, DUET_SHARE_ONE / 4);
    expect_twice(t);
}

static void expect_default(duet_task *t, duet_grade grade)
{
    const duet_plan before = *duet_task_get_plan(t);
    duet_profile found = load(t);
    assert_int_equal(found.grade, grade);
    assert_memory_equal(&found.plan, &before, sizeof before);
    expect_twice(t);
}

TEST(a_changed_kernel_runs_by_the_default_plan)
{
    put("4000", 0.25, "auto twice.WG=16");
    task_files_write(".", "twice", "const int *x\nint *y\n", "y[i] = x[i] + x[i];");
    duet_task *t = create("4000");
    expect_default(t, DUET_GRADE_STALE);
}

TEST(without_a_store_the_plan_is_the_default)
{
    duet_task *t = create("4000");
    expect_default(t, DUET_GRADE_DEFAULT);
}

TEST(a_store_that_cannot_be_read_leaves_a_task_that_runs)
{
    duet_profile profile;
    duet_task *t = create("4000");
    const duet_plan before = *duet_task_get_plan(t);
    test_write_file("store.db", "this is no store, and it is long enough to be seen as none");
    must_fail(duet_task_load_profile(t, "store.db", &profile, ERR), DUET_STATUS_STORE_FAILED,
              "store.db");
    assert_memory_equal(duet_task_get_plan(t), &before, sizeof before);
    expect_twice(t);
}

TEST_EACH(begin, NULL)
TEST_BEGIN(open_pair)
