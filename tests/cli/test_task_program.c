// SPDX-License-Identifier: MIT
// duet run --task and duet tune --task, as a person calls them.
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/json.h"
#include "support/test.h"

#define STORE "DUET_PROFILE=task.db"
#define FEW "--trials 80"

static const char card[] =
    "return { about = 'y = a x + y',\n"
    "  params = { { 'WG', values = { 1, 16 }, about = 'work-items a group' } },\n"
    "  args = { saxpy = [[\n    ulong first\n    ulong last\n    float a\n    const float *x\n"
    "    float *y\n  ]] },\n"
    "  launch = function(p) return { group = p.WG, per_item = 1 } end }\n";

static const char body[] = "__kernel void saxpy(SAXPY_ARGS)\n{\n"
                           "    ulong i = first + get_global_id(0);\n"
                           "    if (i < last)\n        y[i] = a * x[i] + y[i];\n}\n";

static const char task_text[] =
    "local p = parameters{ n = 20000, seed = 1 }\n"
    "return { kernel = 'saxpy', items = p.n, tolerance = 1e-6, key = { n = p.n },\n"
    "  args = { a = 2.0, x = { 'float', p.n, init = 'random', access = 'slice' },\n"
    "    y = { 'float', p.n, init = 'random', access = 'in out slice' } },\n"
    "  reference = function(v) for i = 0, v.items - 1 do v.y[i] = v.a * v.x[i] + v.y[i] end end "
    "}\n";

static void begin_afresh(void)
{
    test_enter_folder();
    test_write_file("saxpy.lua", card);
    test_write_file("saxpy.cl", body);
    test_write_file("saxpy.task.lua", task_text);
}

TEST(a_task_is_run_and_checked)
{
    static const char *const says[] = {"saxpy: 20 000 items of kernel saxpy", "plan: the default",
                                       "duet tune --task saxpy.task.lua",     "items a second",
                                       "right: every launch, within 1e-06",   NULL};
    program p = program_run_with(STORE, "run --task saxpy.task.lua");
    assert_says_all(program_done(p).out, says);
}

// Only sharing is checked then, and the words say so.
TEST(a_kernel_without_a_reference_is_compared_with_itself)
{
    static const refusal cases[] = {
        {"run", "right: every launch, within 1e-06 of what kernel saxpy itself finds on B alone: "
                "only sharing is checked"},
        {"explain", "right: as kernel saxpy itself on B alone, within 1e-06: only sharing is "
                    "checked"},
    };
    char text[sizeof task_text + 2];
    size_t n = (size_t)(strstr(task_text, "  reference") - task_text);
    snprintf(text, sizeof text, "%.*s}\n", (int)n, task_text);
    test_write_file("saxpy.task.lua", text);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        program p = program_run_with(STORE, "%s --task saxpy.task.lua", cases[i].given);
        assert_says(program_done(p).out, cases[i].says);
    }
}

TEST(a_tuned_plan_is_kept_and_used)
{
    const char *const says[] = {"saxpy, 30 000, task saxpy", NULL};
    cJSON *root = json_of_run_with(STORE, "tune --json --task saxpy.task.lua -n 30000 " FEW);
    const cJSON *row = json_row(root, "workloads", 0);
    assert_string_equal(json_string(row, "task"), "saxpy");
    assert_int_equal(json_number(row, "items"), 30000);
    assert_says(json_string(row, "command"), "duet run --task saxpy.task.lua -n 30000");
    assert_true(*json_string(row, "uid"));
    double share = json_number(row, "share");
    bool used = !*json_string(row, "unused");
    root = json_of_run_with(STORE, "run --json --task saxpy.task.lua -n 30000");
    assert_string_equal(json_string(root, "plan_from"), used ? "exact" : "default");
    assert_true(!used || json_number(root, "share") == share);
    root = json_of_run_with(STORE, "profiles why --json --task saxpy.task.lua -n 30000");
    assert_string_equal(json_string(root, "grade"), used ? "exact" : "default");
    program p = program_run_with(STORE, "profiles list");
    if (used)
        assert_says_all(program_done(p).out, says);
    root = json_of_run_with(STORE, "tune --json --task saxpy.task.lua -n 30000 " FEW);
    row = json_row(root, "workloads", 0);
    assert_true(json_true(row, "known"));
}

TEST(a_task_is_explained)
{
    static const char *const says[] = {
        "saxpy: 20 000 items of kernel saxpy", "in out slice",
        "2 valid sets of parameters",          "right: as the file's reference, within 1e-06",
        "in the store: task saxpy; n 20000",   NULL};
    program p = program_run_with(STORE, "explain --task saxpy.task.lua");
    assert_says_all(program_done(p).out, says);
    cJSON *root = json_of_run_with(STORE, "explain --json --task saxpy.task.lua -n 500");
    assert_int_equal(json_number(root, "items"), 500);
    const cJSON *args = json_field(root, "arguments");
    assert_int_equal(cJSON_GetArraySize(args), 3);
    assert_int_equal(json_number(cJSON_GetArrayItem(args, 1), "an_item"), 1);
    const cJSON *kernels = json_field(root, "kernels");
    const cJSON *b = cJSON_GetArrayItem(kernels, cJSON_GetArraySize(kernels) - 1);
    assert_int_equal(json_number(b, "configs"), 2);
}

TEST(a_task_is_measured_and_compared)
{
    program p =
        program_run_with(STORE, "bench --task saxpy.task.lua -n 3000 --repeat 7 -o old.json");
    assert_says(program_done(p).out, "task saxpy, 3 000 items", "kernels");
    cJSON *root = json_of_run_with(STORE, "bench --task saxpy.task.lua -n 3000 --repeat 7 --json");
    const cJSON *one, *cases = json_field(root, "cases");
    assert_true(cJSON_GetArraySize(cases) == (devices_are_two() ? 5 : 1));
    cJSON_ArrayForEach(one, cases)
    {
        assert_string_equal(json_string(one, "scene"), "saxpy");
        assert_int_equal(json_number(one, "objects"), 3000);
        assert_int_equal(json_size(one, "samples_ms"), 7);
    }
    p = program_run_with(STORE, "bench --task saxpy.task.lua -n 3000 --against old.json");
    assert_says(p.out, "against ");
    p = program_run_with(STORE, "bench --task saxpy.task.lua -n 4000 --against old.json");
    assert_says(program_done(p).out, "task saxpy, 4 000 items", "new");
    program_assert_refused(program_run("bench -n 3"), 2, "--task");
    program_assert_refused(program_run("bench --scene paper --task saxpy.task.lua"), 2, "--scene");
    test_write_file("saxpy.cl", "__kernel void saxpy(SAXPY_ARGS) { if (get_global_id(0) == 0) "
                                "y[first] = 7; }");
    p = program_run("bench --task saxpy.task.lua");
    assert_int_equal(p.exit_code, 1);
    assert_says(p.err, "item 0: y[0] is 7", "failed");
    assert_null(strstr(p.err, " 1 plans"));
}

// A tune file has tasks and a scene; its modes and levels are the scene's.
TEST(a_tune_file_has_tasks)
{
    test_write_file("tune.lua", "return { workloads = { { task = 'saxpy.task.lua', n = { 3000, "
                                "4000 }, set = { seed = 2 } }, { scene = 'paper', n = 300 } }, "
                                "modes = { 'own' }, level = 'certified', variants = { 'simd' }, "
                                "budget = { trials = 80 } }");
    cJSON *root = json_of_run_with(STORE, "tune --json --config tune.lua");
    const cJSON *rows = json_field(root, "workloads");
    assert_int_equal(cJSON_GetArraySize(rows), 3);
    for (int i = 0; i < 2; ++i) {
        const cJSON *row = cJSON_GetArrayItem(rows, i);
        assert_string_equal(json_string(row, "task"), "saxpy");
        assert_int_equal(json_number(row, "items"), 3000 + 1000 * i);
        assert_says(json_string(row, "command"), "--task saxpy.task.lua -n");
    }
    assert_int_equal(json_number(cJSON_GetArrayItem(rows, 2), "objects"), 300);
}

TEST(a_wrong_task_in_a_tune_file_is_told)
{
    static const refusal cases[] = {
        {"n = 5",
         "tune.lua:1: workload 1: it has no scene and no task; expected a scene or a task"},
        {"scene = 'paper', task = 'saxpy.task.lua'", "it has a scene and a task"},
        {"task = 'saxpy.task.lua', query = 'rays'", "a task has no query; expected a scene"},
        {"task = 'saxpy.task.lua', steps = 9", "steps is a number of 2 or more, of a scene"},
        {"task = 'none.task.lua'", "none.task.lua"},
        {"task = 'saxpy.task.lua', set = { m = 1 }", "no parameter 'm'; the task has n, seed"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[200];
        snprintf(text, sizeof text, "return { workloads = { { %s } } }", cases[i].given);
        test_write_file("tune.lua", text);
        program p = program_run_with(STORE, "tune --config tune.lua");
        if (p.exit_code == 0 || !strstr(p.err, cases[i].says))
            fail_msg("%s: %d '%s'", cases[i].given, p.exit_code, p.err);
    }
}

// The kernel's text is part of what was measured.
TEST(a_changed_kernel_is_another_workload)
{
    program_done(program_run_with(STORE, "tune --task saxpy.task.lua " FEW));
    test_write_file("saxpy.cl",
                    "__kernel void saxpy(SAXPY_ARGS)\n{\n    ulong i = first + "
                    "get_global_id(0);\n    if (i < last)\n        y[i] += a * x[i];\n}\n");
    cJSON *root = json_of_run_with(STORE, "run --json --task saxpy.task.lua");
    assert_string_equal(json_string(root, "plan_from"), "default");
}

// Watts that never change: energy follows time.
TEST(energy_is_made_small_and_kept_beside_time)
{
    test_write_file("energy.txt", "50 W\n");
    cJSON *root = json_of_run_with(STORE " DUET_ENERGY=energy.txt",
                                   "tune --json --task saxpy.task.lua --pair halves --repeat 1 "
                                   "--objective energy --trials 120");
    const cJSON *row = json_field(root, "workloads")->child;
    assert_true(json_number(row, "joules") > 0 && json_number(row, "plans_tried") > 3);
    cJSON *shown = json_of_run_with(STORE, "profiles show --json %.8s", json_string(row, "uid"));
    assert_string_equal(json_string(shown, "objective"), "energy");
    double ms = 0, joules = 1e9;
    const cJSON *plan;
    cJSON_ArrayForEach(plan, json_field(shown, "pareto"))
    {
        assert_true(json_number(plan, "ms") > ms && json_number(plan, "joules") < joules);
        ms = json_number(plan, "ms");
        joules = json_number(plan, "joules");
    }
    assert_true(ms > 0);
    program_assert_refused(program_run_with(STORE " DUET_ENERGY=none.txt",
                                            "tune --task saxpy.task.lua "
                                            "--objective energy"),
                           1, "energy: none.txt: expected a number, then J");
    program_assert_refused(program_run_with(STORE, "tune --task saxpy.task.lua --objective speed"),
                           2, "objective 'speed': expected 'time' or 'energy'");
}

TEST(wrong_calls_are_refused)
{
    static const struct {
        const char *arguments;
        int exit_code;
        const char *says;
    } cases[] = {
        {"run", 2, "SCENE|FILE is missing"},
        {"run paper --task saxpy.task.lua", 2, "--task: the file says what it is"},
        {"run --task saxpy.task.lua --check", 2, "--task"},
        {"run --task saxpy.task.lua --set m=1", 2, "no parameter 'm'; the task has n, seed"},
        {"run --task none.task.lua", 2, "none.task.lua"},
        {"profiles why paper --task saxpy.task.lua", 2, "--task: the file says what it is"},
        {"profiles why", 2, "SCENE|FILE is missing"},
        {"explain", 2, "SCENE|FILE is missing"},
        {"explain paper --task saxpy.task.lua", 2, "--task: the file says what it is"},
        {"explain --task saxpy.task.lua --measure", 2, "--measure"},
        {"tune paper --task saxpy.task.lua", 2, "paper: with --task the file says what is tuned"},
        {"tune --task saxpy.task.lua --query rays", 2, "--task"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        program p = program_run_with(STORE, "%s", cases[i].arguments);
        if (p.exit_code == 0 || !strstr(p.err, cases[i].says))
            fail_msg("%s: %d '%s'", cases[i].arguments, p.exit_code, p.err);
        assert_true(p.exit_code == cases[i].exit_code || i == 4);
    }
}

TEST(a_wrong_kernel_fails_with_one_line)
{
    test_write_file("saxpy.cl", "__kernel void saxpy(SAXPY_ARGS)\n{\n    ulong i = first + "
                                "get_global_id(0);\n    if (i < last)\n        y[i] = x[i];\n}\n");
    static const char *const commands[] = {"run", "tune"};
    for (int i = 0; i < 2; ++i)
        program_assert_refused(program_run_with(STORE, "%s --task saxpy.task.lua", commands[i]), 1,
                               "task saxpy: item 0: y[0] is ");
}

// A kernel's name in a file is the file's, whichever field and command.

// The compiler knows the text by a name that is the same in all folders.
TEST(a_kernel_that_does_not_compile_is_named_as_the_file_that_was_read)
{
    static const char *const stores[] = {STORE, STORE " DUET_KERNEL_DIR=."};
    test_write_file("saxpy.cl", "__kernel void saxpy(SAXPY_ARGS)\n{\n    y[first] = ;\n}\n");
    for (size_t i = 0; i < sizeof stores / sizeof *stores; ++i) {
        program p = program_run_with(stores[i], "run --task saxpy.task.lua");
        assert_int_equal(p.exit_code, 1);
        if (!strstr(p.err, "./saxpy.cl:3:") || strstr(p.err, "kernels/"))
            fail_msg("%s", p.err);
    }
}

#define Y "args = { y = { 'float', 4, access = 'out slice' } }"
TEST(a_name_of_no_kernel_is_told_with_its_line)
{
    static const refusal cases[] = {
        {"return { items = 4, " Y ",\n  kernel = 'nosuch' }",
         "wrong.task.lua:2: kernel is 'nosuch'; expected a kernel: there are saxpy"},
        {"return { items = 4, " Y ", kernel = 'saxpy',\n\n  reference = 'nosuch' }",
         "wrong.task.lua:3: reference is 'nosuch'; expected a kernel: there are saxpy"},
    };
    static const char *const commands[] = {"run", "tune", "bench", "explain", "profiles why"};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        test_write_file("wrong.task.lua", cases[i].given);
        for (size_t c = 0; c < sizeof commands / sizeof *commands; ++c)
            program_assert_refused(program_run_with(STORE, "%s --task wrong.task.lua", commands[c]),
                                   1, cases[i].says);
    }
}

TEST_EACH(begin_afresh, NULL)
