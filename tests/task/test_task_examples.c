// SPDX-License-Identifier: MIT
// The example tasks find what they should with every valid set of parameters of their kernels.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "runtime/opencl/device_pair.h"
#include "runtime/task/task_launch.h"

static char folder[512];

static void find_folder(void)
{
    snprintf(folder, sizeof folder, "%s/../../examples/tasks", getenv("DUET_TEST_DATA"));
}

static duet_device_pair *open_with_examples(void)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.kernel_dir = folder;
    return kept(duet_device_pair_create(&def, ERR));
}

// Both devices run each config, at a share that cuts groups apart.
static void launch_configs(task_launcher *l)
{
    duet_error err = {0};
    task_result r;
    own(kernel_spaces) spaces = {0};
    duet_plan plan = {.mode = DUET_MODE_OWN, .variant_a = "auto", .variant_b = "auto"};
    must(task_kernel_space(l, &plan, 1, &spaces, ERR));
    assert_int_equal(spaces.n, 1);
    const kernel_space *space = spaces.of;
    assert_true(space->n_configs >= 9);
    for (uint32_t i = 0; i < space->n_configs; ++i) {
        plan.share = (i * 7919u) % DUET_SHARE_ONE;
        strcpy(plan.variant_a, "auto");
        assert_true(kernel_space_write(space, i, plan.variant_a));
        strcpy(plan.variant_b, plan.variant_a);
        if (!task_launch(l, &plan, &r, &err))
            fail_msg("%s: %s", plan.variant_a, err.text);
    }
}

static void run_example(const char *name, const char *n)
{
    const duet_setting setting = {"n", n};
    char path[600];
    snprintf(path, sizeof path, "%s/%s.task.lua", folder, name);
    task *t = kept(task_load(path, &setting, 1, ERR));
    duet_device_pair *pair = open_with_examples();
    for (int copies = 0; copies < 2; ++copies) {
        for (int side = 0; side < 2; ++side)
            pair->devices[side].info.host_memory &= !copies;
        task_launcher *l = must(task_launcher_open(t, pair, ERR));
        launch_configs(l);
        task_launcher_close(l);
    }
}

// The right values for few items are found by Lua, and for many by the plain kernel, which finds
// the same.
static void run_plain(const char *name, const char *n)
{
    const duet_setting setting = {"n", n};
    char path[600];
    task_result r;
    duet_plan plan = {.mode = DUET_MODE_OWN, .variant_a = "auto", .variant_b = "auto"};
    snprintf(path, sizeof path, "%s/%s.task.lua", folder, name);
    task *t = kept(task_load(path, &setting, 1, ERR));
    assert_string_equal(t->reference, "");
    snprintf(t->kernel, sizeof t->kernel, "%s_plain", name);
    snprintf(t->entry, sizeof t->entry, "%s_plain", name);
    duet_device_pair *pair = open_with_examples();
    task_launcher *l = must(task_launcher_open(t, pair, ERR));
    for (uint32_t i = 0; i <= 4; ++i) {
        plan.share = DUET_SHARE_ONE / 4 * i;
        must(task_launch(l, &plan, &r, ERR));
    }
    task_launcher_close(l);
}

// More items than Lua finds in a moment; the file's reference is then the plain kernel.
TEST(many_items_have_a_kernel_as_their_reference)
{
    static const char *const names[] = {"saxpy", "histogram", "stencil", "black_scholes"};
    for (int i = 0; i < 4; ++i) {
        const duet_setting setting = {"n", i == 2 ? "3907" : "4000001"};
        char path[600], plain[40];
        run_plain(names[i], i == 2 ? "9" : "3001");
        snprintf(path, sizeof path, "%s/%s.task.lua", folder, names[i]);
        snprintf(plain, sizeof plain, "%s_plain", names[i]);
        task *t = must(task_load(path, &setting, 1, ERR));
        assert_string_equal(t->reference, plain);
        task_destroy(t);
    }
}

TEST(saxpy_is_right)
{
    run_example("saxpy", "5003");
}

TEST(nbody_is_right)
{
    run_example("nbody", "331");
}

typedef struct attraction {
    double found[3]; // in double
    double sizes[3]; // of the terms, summed
} attraction;

static attraction attract(const float *bodies, uint32_t n, uint32_t i)
{
    const double softening = 0.01f, gravity = (float)(1.0 / n);
    attraction a = {{0}, {0}};
    for (uint32_t j = 0; j < n; ++j) {
        double d[3], squared = softening;
        for (uint32_t k = 0; k < 3; ++k) {
            d[k] = (double)bodies[4 * j + k] - bodies[4 * i + k];
            squared += d[k] * d[k];
        }
        for (uint32_t k = 0; k < 3; ++k) {
            double term = gravity * bodies[4 * j + 3] * d[k] / (squared * sqrt(squared));
            a.found[k] += term;
            a.sizes[k] += fabs(term);
        }
    }
    return a;
}

// Checks a few bodies beside sums in double, within the bound that nbody.task.lua derives for the
// kernel alone, by the sizes of each body's own terms.
static void expect_attraction(duet_task *t, uint32_t n)
{
    const float *bodies = duet_task_get_array(t, "bodies", NULL, NULL);
    const float *found = duet_task_get_array(t, "acceleration", NULL, NULL);
    const double roundings = 26 + ceil(n / 256.0) + 255 + 1;
    assert_true(bodies && found);
    for (uint32_t i = 0; i < n; i += n / 61) {
        attraction a = attract(bodies, n, i);
        for (uint32_t k = 0; k < 3; ++k) {
            double bound = 1.001 * roundings * 0x1p-24 * a.sizes[k];
            if (!(fabs(found[4 * i + k] - a.found[k]) <= bound))
                fail_msg("body %u: %.9g instead of %.9g within %g", i, (double)found[4 * i + k],
                         a.found[k], bound);
            assert_true(bound < 0.002); // so that one lost body shows in its neighbours
        }
    }
}

TEST(nbody_of_16384_is_within_its_bound)
{
    enum { N = 16384 };
    const duet_setting setting = {"n", "16384"};
    char path[600];
    duet_task_result r;
    snprintf(path, sizeof path, "%s/nbody.task.lua", folder);
    duet_device_pair *pair = open_with_examples();
    duet_task_def def = duet_default_task_def();
    def.pair = pair;
    def.path = path;
    def.settings = &setting;
    def.n_settings = 1;
    def.plan.share = DUET_SHARE_ONE / 3;
    duet_task *t = kept(duet_task_create(&def, ERR));
    must(duet_task_run(t, &r, ERR));
    expect_attraction(t, N);
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

TEST_BEGIN(find_folder)
