// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "support/program.h"
#include "support/test.h"

#include "runtime/duet.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void help_and_version_are_printed(void **state)
{
    (void)state;
    program p = program_run("--version");
    assert_int_equal(p.exit_code, 0);
    assert_string_equal(p.out, "duet 1.0.0\n");
    program_free(&p);
    p = program_run("--help");
    assert_int_equal(p.exit_code, 0);
    assert_non_null(strstr(p.out, "devices"));
    program_free(&p);
}

// Every subcommand that --help names has a --help of its own.
static void every_subcommand_has_help(void **state)
{
    (void)state;
    program all = program_run("--help");
    int n = 0;
    for (char *line = strtok(all.out, "\n"); line; line = strtok(NULL, "\n")) {
        char name[32];
        if (strncmp(line, "  ", 2) != 0 || sscanf(line, " %31[a-z]", name) != 1)
            continue;
        program p = program_run("%s --help", name);
        char begin[64];
        snprintf(begin, sizeof begin, "duet %s", name);
        assert_int_equal(p.exit_code, 0);
        assert_int_equal(strncmp(p.out, begin, strlen(begin)), 0);
        assert_non_null(strstr(p.out, "--help"));
        program_free(&p);
        ++n;
    }
    assert_true(n > 0);
    program_free(&all);
}

static void wrong_usage_is_one_line_and_exit_2(void **state)
{
    (void)state;
    static const char *const wrong[][2] = {
        {"", "a subcommand is missing"},
        {"abacus", "there is no subcommand 'abacus'"},
        {"devices --abacus", "there is no option '--abacus'"},
        {"devices -x", "there is no option '-x'"},
        {"devices --json=1", "--json takes no value"},
        {"devices scene.lua", "'scene.lua' is one argument too many"},
        {"devices -- --json", "'--json' is one argument too many"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        program p = program_run("%s", wrong[i][0]);
        program_assert_refused(&p, 2, wrong[i][1]);
    }
}

static void devices_are_listed_as_one_json_object(void **state)
{
    (void)state;
    program p = program_run("devices --json");
    assert_int_equal(p.exit_code, 0);
    assert_string_equal(p.err, "");
    const char *end = NULL;
    cJSON *o = cJSON_ParseWithOpts(p.out, &end, false);
    assert_true(cJSON_IsObject(o));
    assert_string_equal(end, "\n");
    cJSON *devices = cJSON_GetObjectItemCaseSensitive(o, "devices");
    assert_true(cJSON_GetArraySize(devices) > 0);
    cJSON *selector = cJSON_GetObjectItemCaseSensitive(cJSON_GetArrayItem(devices, 0), "selector");
    assert_true(cJSON_IsString(selector));
    cJSON_Delete(o);
    program_free(&p);
}

static void a_machine_without_opencl_is_told_what_to_install(void **state)
{
    (void)state;
    static const char *const commands[] = {"devices", "devices --json"};
    for (int i = 0; i < 2; ++i) {
        program p = program_run_with("OCL_ICD_VENDORS=no/such/folder", "%s", commands[i]);
        program_assert_refused(&p, 1, "apt install pocl-opencl-icd");
    }
}

static void a_full_disk_is_a_failure(void **state)
{
    (void)state;
    program p = program_run("devices --json >/dev/full");
    program_assert_refused(&p, 1, "stdout: No space left on device");
}

static void a_reader_that_went_away_is_a_failure(void **state)
{
    (void)state;
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    close(ends[0]);
    assert_int_equal(dup2(ends[1], 9), 9);
    program p = program_run("--help >&9");
    program_assert_refused(&p, 1, "stdout: Broken pipe");
    close(9);
    close(ends[1]);
    p = program_run("--help >&-");
    program_assert_refused(&p, 1, "stdout: ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(help_and_version_are_printed),
        cmocka_unit_test(every_subcommand_has_help),
        cmocka_unit_test(wrong_usage_is_one_line_and_exit_2),
        cmocka_unit_test(devices_are_listed_as_one_json_object),
        cmocka_unit_test(a_machine_without_opencl_is_told_what_to_install),
        cmocka_unit_test(a_full_disk_is_a_failure),
        cmocka_unit_test(a_reader_that_went_away_is_a_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
