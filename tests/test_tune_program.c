// SPDX-License-Identifier: MIT
// duet tune, as a person calls it, and tune files.
#define _POSIX_C_SOURCE 200809L
#include "support/program.h"
#include "support/test.h"

#include "runtime/base/text.h"
#include "tuner/tune_config.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCENE "test_tune.scene.lua"
#define STORE "test_tune.db"
#define CONFIG "test_tune.tune.lua"
#define QUICK "--variants rows --store " STORE " "

static const char scene_text[] =
    "local p = parameters { n = 2000, seed = 1 }\n"
    "local random = random(p.seed)\n"
    "for _ = 1, p.n do\n"
    "  local x, y, z = random.uniform(0, 15), random.uniform(0, 15), random.uniform(0, 15)\n"
    "  add(x, y, z, 0.5, 0.5, 0.5, random.quaternion())\n"
    "end\n"
    "return { dims = 3 }\n";

static void write_file(const char *path, const char *content)
{
    duet_error err = {0};
    assert_ok(text_write_file(path, content, strlen(content), &err), err);
}

static int remove_files(void **state)
{
    (void)state;
    static const char *const files[] = {SCENE, CONFIG, STORE, STORE "-wal", STORE "-shm"};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i)
        remove(files[i]);
    return 0;
}

static int begin_afresh(void **state)
{
    remove_files(state);
    write_file(SCENE, scene_text);
    return 0;
}

// The rows of "workloads"; the caller deletes their root.
static cJSON *tune_json(const char *arguments, const cJSON **rows)
{
    program p = program_run("tune --json %s", arguments);
    if (p.exit_code != 0)
        fail_msg("tune --json %s: %s", arguments, p.err);
    cJSON *root = cJSON_Parse(p.out);
    *rows = cJSON_GetObjectItemCaseSensitive(root, "workloads");
    assert_true(cJSON_IsArray(*rows));
    program_free(&p);
    return root;
}

static double number(const cJSON *row, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(row, key);
    if (!cJSON_IsNumber(item))
        fail_msg("no number '%s'", key);
    return item->valuedouble;
}

static bool is_true(const cJSON *row, const char *key)
{
    return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(row, key));
}

static void a_workload_is_tuned_once_and_known_ever_after(void **state)
{
    (void)state;
    const cJSON *rows;
    cJSON *first = tune_json(QUICK SCENE " --n 1000,2000", &rows);
    assert_int_equal(cJSON_GetArraySize(rows), 2);
    const cJSON *row = cJSON_GetArrayItem(rows, 1);
    assert_int_equal(number(row, "objects"), 2000);
    assert_true(number(row, "launches") > 0 && number(row, "seconds") > 0);
    assert_true(number(row, "gain_low") <= number(row, "gain"));
    assert_true(number(row, "gain") <= number(row, "gain_high"));
    assert_false(is_true(row, "resumed"));
    double share = number(row, "share");
    cJSON_Delete(first);
    cJSON *second = tune_json(QUICK SCENE " --n 2000", &rows);
    row = cJSON_GetArrayItem(rows, 0);
    assert_true(is_true(row, "resumed"));
    assert_int_equal(number(row, "launches"), 0);
    assert_true(number(row, "share") == share);
    cJSON_Delete(second);
    cJSON *fresh = tune_json(QUICK SCENE " --n 2000 --fresh", &rows);
    assert_true(number(cJSON_GetArrayItem(rows, 0), "launches") > 0);
    cJSON_Delete(fresh);
}

// Stopped at several moments, by kill -9 and by Ctrl-C; what was measured
// before each stays measured.
static void a_stopped_tuning_is_taken_up_again(void **state)
{
    (void)state;
    static const char *const stops[] = {"KILL 0.3", "INT 0.4", "KILL 0.5", "KILL 0.6", "INT 0.7"};
    const char *duet = getenv("DUET_PROGRAM");
    assert_non_null(duet);
    for (size_t i = 0; i < sizeof stops / sizeof *stops; ++i) {
        text command = {0};
        text_add(&command, "timeout -s %s '%s' tune " QUICK "--repeat 32 " SCENE " >/dev/null 2>&1",
                 stops[i], duet);
        int status = system(text_chars(&command));
        (void)status; // stopped, or finished before on a fast machine
        text_free(&command);
    }
    const cJSON *rows;
    cJSON *root = tune_json(QUICK "--repeat 32 " SCENE, &rows);
    assert_true(is_true(cJSON_GetArrayItem(rows, 0), "resumed"));
    cJSON_Delete(root);
}

static void a_budget_of_trials_is_kept(void **state)
{
    (void)state;
    const cJSON *rows;
    cJSON *root = tune_json(QUICK "--trials 12 --repeat 1 --strategy fig12 " SCENE, &rows);
    assert_in_range(number(cJSON_GetArrayItem(rows, 0), "launches"), 1, 24);
    cJSON_Delete(root);
}

static void a_tune_file_sweeps_with_a_strategy_of_its_own(void **state)
{
    (void)state;
    write_file(CONFIG,
               "return {\n"
               "  workloads = { { scene = '" SCENE "', n = { 500, 600 }, set = { seed = 3 } } },\n"
               "  variants = { 'rows' }, modes = { 'own' }, repeats = 1,\n"
               "  budget = { trials = 30 },\n"
               "  strategy = function(history)\n"
               "    if #history < 3 then return #history / 2 end\n"
               "  end,\n"
               "}\n");
    const cJSON *rows;
    cJSON *root = tune_json("--store " STORE " --config " CONFIG, &rows);
    assert_int_equal(cJSON_GetArraySize(rows), 2);
    assert_int_equal(number(cJSON_GetArrayItem(rows, 0), "objects"), 500);
    assert_int_equal(number(cJSON_GetArrayItem(rows, 1), "objects"), 600);
    cJSON_Delete(root);
}

static void what_is_wrong_on_the_command_line_is_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *arguments;
        int exit_code;
        const char *says;
    } rows[] = {
        {"tune", 2, "give a scene"},
        {"tune " QUICK SCENE " --n 10,x", 2, "--n '10,x'"},
        {"tune " QUICK SCENE " --strategy guess", 1, "there are balance, fig12"},
        {"tune --variants nonsense --store " STORE " " SCENE, 2, "nonsense"},
        {"tune " QUICK " no/such.lua", 1, "no/such.lua"},
        {"tune --store " SCENE " " SCENE, 1, SCENE},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        program p = program_run("%s", rows[i].arguments);
        program_assert_refused(&p, rows[i].exit_code, rows[i].says);
    }
}

static void what_is_wrong_in_a_tune_file_is_said_with_its_line(void **state)
{
    (void)state;
    static const struct {
        const char *content;
        const char *says;
    } rows[] = {
        {"return 1", CONFIG},
        {"return {}", "workloads"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n stratgy = 'grid' }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua', m = 3}} }", CONFIG ":2:"},
        {"return {\n workloads = {{scene = 'a.lua', n = 'many'}} }", CONFIG ":2:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n strategy = 'best' }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n modes = {'both'} }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n budget = {minutes = 1} }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n objective = 'beauty' }", CONFIG ":3:"},
        {"return {\n workloads = {} }", CONFIG ":2:"},
        {"return {", CONFIG ":1:"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        static tune_config config;
        duet_error err = {0};
        write_file(CONFIG, rows[i].content);
        assert_false(tune_config_load(&config, CONFIG, &err));
        assert_int_equal(err.status, DUET_BAD_INPUT);
        if (!strstr(err.text, rows[i].says))
            fail_msg("'%s' is not in: %s", rows[i].says, err.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_workload_is_tuned_once_and_known_ever_after, begin_afresh),
        cmocka_unit_test_setup(a_stopped_tuning_is_taken_up_again, begin_afresh),
        cmocka_unit_test_setup(a_budget_of_trials_is_kept, begin_afresh),
        cmocka_unit_test_setup(a_tune_file_sweeps_with_a_strategy_of_its_own, begin_afresh),
        cmocka_unit_test_setup(what_is_wrong_on_the_command_line_is_one_line, begin_afresh),
        cmocka_unit_test_setup(what_is_wrong_in_a_tune_file_is_said_with_its_line, begin_afresh),
    };
    return cmocka_run_group_tests(tests, NULL, remove_files);
}
