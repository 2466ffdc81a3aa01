// SPDX-License-Identifier: MIT
// A task whose share follows its runs: each finds what it should, whatever the share is.
#include "support/devices.h"
#include "support/task_files.h"
#include "support/test.h"

#include "tuner/duet_tune.h"

enum { N = 2000, MOST_RUNS = 1500 };

static duet_task *open_task(void)
{
    task_files_write(".", "spin", "const int *x\nint *y\n",
                     "int v = x[i]; for (int k = 0; k < 2000; ++k) v = v * 5 + 3; y[i] = v;");
    test_write_file("spin.task.lua",
                    "return { kernel = 'spin', items = 2000, args = { x = { 'int', 2000, init = "
                    "'index', access = 'slice' }, y = { 'int', 2000, access = 'out slice' } } }");
    duet_task_def def = duet_default_task_def();
    def.pair = default_pair();
    def.path = "spin.task.lua";
    def.plan.share = DUET_SHARE_ONE / 100 * 97;
    return kept(duet_task_create(&def, ERR));
}

static void expect_right(duet_task *t)
{
    const int32_t *y = duet_task_get_array(t, "y", NULL, NULL);
    assert_non_null(y);
    for (int i = 0; i < N; i += 37) {
        uint32_t v = (uint32_t)i;
        for (int k = 0; k < 2000; ++k)
            v = v * 5 + 3;
        assert_int_equal((uint32_t)y[i], v);
    }
}

// A does 97 of 100 items, and B waits.
TEST(the_share_moves_from_the_device_that_is_waited_for)
{
    skip_on_one_device();
    duet_task_result result;
    duet_task *t = open_task();
    duet_online_def def = duet_default_online_def();
    def.task = t;
    duet_online *o = must(duet_online_create(&def, ERR));
    const uint32_t before = duet_task_get_plan(t)->share;
    int run = 0;
    for (; run < MOST_RUNS && duet_task_get_plan(t)->share >= before; ++run) {
        must(duet_online_run(o, &result, ERR));
        expect_right(t);
    }
    assert_true(run < MOST_RUNS);
    must(duet_online_destroy(o, ERR));
}

TEST(what_a_task_has_not_is_refused)
{
    duet_task *t = open_task();
    duet_online_def def = duet_default_online_def();
    def.task = t;
    for (int i = 0; i < 2; ++i) {
        duet_online_def wrong = def;
        wrong.keep = i == 0;
        wrong.n_variants = (uint32_t)i;
        must_fail(duet_online_create(&wrong, ERR), DUET_STATUS_BAD_ARGUMENT,
                  "expected none for a task, whose share alone moves");
    }
    duet_result result;
    duet_online *o = must(duet_online_create(&def, ERR));
    must_fail(duet_online_step(o, &result, ERR), DUET_STATUS_BAD_ARGUMENT, "the def had no world");
    assert_true(duet_online_destroy(o, NULL));
}
