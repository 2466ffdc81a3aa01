// SPDX-License-Identifier: MIT
// The example tasks find what they should with every valid set of parameters of their kernels.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "runtime/opencl/device_pair.h"
#include "runtime/task/task_launch.h"

#include <stdio.h>
#include <stdlib.h>

static char folder[512];

static int find_folder(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "%s/../../examples/tasks", getenv("DUET_TEST_DATA"));
    return 0;
}

static duet_device_pair *open_with_examples(void)
{
    duet_error err = {0};
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = folder;
    duet_device_pair *pair = duet_device_pair_create(&def, &err);
    assert_ok(pair, err);
    return pair;
}

// Both devices run each config, at a share that cuts groups apart.
static void launch_configs(task_launcher *l)
{
    duet_error err = {0};
    task_result r;
    kernel_space *space;
    uint32_t n;
    duet_plan plan = {.mode = DUET_MODE_OWN, .variant_a = "auto", .variant_b = "auto"};
    assert_ok(task_kernel_space(l, &plan, 1, &space, &n, &err), err);
    assert_int_equal(n, 1);
    assert_true(space->n_configs >= 9);
    for (uint32_t i = 0; i < space->n_configs; ++i) {
        plan.share = (i * 7919u) % DUET_SHARE_ONE;
        assert_true(kernel_space_write(space, i, "auto", plan.variant_a, sizeof plan.variant_a));
        assert_true(kernel_space_write(space, i, "auto", plan.variant_b, sizeof plan.variant_b));
        if (!task_launch(l, &plan, &r, &err))
            fail_msg("%s: %s", plan.variant_a, err.text);
    }
    free(space);
}

static void run_example(const char *name, const char *n)
{
    const duet_setting setting = {"n", n};
    char path[600];
    duet_error err = {0};
    snprintf(path, sizeof path, "%s/%s.task.lua", folder, name);
    task *t = task_load(path, &setting, 1, &err);
    assert_ok(t, err);
    duet_device_pair *pair = open_with_examples();
    for (int copies = 0; copies < 2; ++copies) {
        for (int side = 0; side < 2; ++side)
            pair->devices[side].info.host_memory &= !copies;
        task_launcher *l = task_launcher_open(t, pair, &err);
        assert_ok(l, err);
        launch_configs(l);
        task_launcher_close(l);
    }
    duet_device_pair_destroy(pair);
    task_destroy(t);
}

TEST(saxpy_is_right)
{
    run_example("saxpy", "5003");
}

TEST(nbody_is_right)
{
    run_example("nbody", "331");
}

TEST(histogram_is_right)
{
    run_example("histogram", "70001");
}

TEST(stencil_is_right)
{
    run_example("stencil", "7");
}

TEST(matmul_is_right)
{
    run_example("matmul", "53");
}

TEST(black_scholes_is_right)
{
    run_example("black_scholes", "2001");
}

TEST_MAIN(find_folder, NULL)
