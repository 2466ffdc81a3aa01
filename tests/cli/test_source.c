// SPDX-License-Identifier: MIT
// duet source, as a person calls it.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/test.h"

static char data_dir[512]; // "DUET_KERNEL_DIR=..." of the test kernels

static void find_data(void)
{
    snprintf(data_dir, sizeof data_dir, "DUET_KERNEL_DIR='%s/kernels'", getenv("DUET_TEST_DATA"));
}

static const cJSON *item_named(const cJSON *list, const char *name)
{
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, list)
    {
        if (strcmp(json_string(item, "name"), name) == 0)
            return item;
    }
    fail_msg("nothing is named %s", name);
    return NULL;
}

TEST(the_text_is_printed_and_nothing_else)
{
    program p = program_done(program_run("source scan --set WG=64 --set PER_ITEM=4"));
    assert_string_equal(p.err, "");
    assert_int_equal(strncmp(p.out, "// scan.WG64.PER_ITEM4\n#define WG 64\n", 37), 0);
    program again = program_run("source scan --set PER_ITEM=4 --set WG=64");
    assert_string_equal(p.out, again.out);
}

TEST(json_has_the_text_and_its_hash)
{
    cJSON *o = json_of_run("source scan --json");
    program p = program_run("source scan | sha256sum");
    const char *hash = json_string(o, "sha256");
    assert_int_equal(strncmp(p.out, hash, 64), 0);
}

TEST(a_device_decides_defaults)
{
    program p = program_run("source scan --device pocl:0");
    assert_says(p.out, "#define WG 1\n");
    p = program_run("source scan");
    assert_says(p.out, "#define WG 256\n");
}

TEST(a_scene_decides_what_is_compiled_in)
{
    const char flat[] = "0 0 1 1\n2 2 3 3\n"; // 2D bounds
    test_write_file("test_source.csv", flat);
    program p = program_run("source hash --scene test_source.csv");
    assert_says(p.out, "#define DIMS 2\n#define SHAPE 1\n#define ROTATED 0\n");
    p = program_run("source scan --scene test_source.csv"); // has none of these
    assert_int_equal(p.exit_code, 0);
    program_assert_refused(program_run("source hash --scene no_such.csv"), 1, "no_such.csv");
}

TEST(kernels_are_listed_with_what_varies)
{
    cJSON *o = json_of_run_with(data_dir, "source --list --json");
    const cJSON *kernels = json_field(o, "kernels");
    const cJSON *plain = item_named(kernels, "plain");
    assert_int_equal(json_number(plain, "configs"), 15);
    const cJSON *params = json_field(plain, "params");
    assert_int_equal(json_number(item_named(params, "WG"), "default"), 64);
    assert_int_equal(json_number(item_named(params, "SHIFT"), "min"), -8);
    assert_int_equal(json_number(item_named(kernels, "shaped"), "configs"), 2);
    program p = program_run_with(data_dir, "source --list plain");
    assert_says(p.out, "FACTOR    [1] 2 3", "SHIFT     -8 .. 8 [-1]", "15 valid configs");
    assert_null(strstr(p.out, "shaped"));
}

TEST(a_folder_replaces_the_carried_kernels)
{
    program p = program_run_with("DUET_KERNEL_DIR=", "source scan"); // empty counts as not set
    assert_int_equal(p.exit_code, 0);
    program_assert_refused(program_run_with(data_dir, "source scan"), 2,
                           "no kernel 'scan'; 'duet source --list' lists those there are");
    program_assert_refused(program_run_with("DUET_KERNEL_DIR=no/such", "source scan"), 1,
                           "kernel folder no/such: No such file or directory");
}

TEST(every_config_of_a_small_space_is_compiled)
{
    cJSON *o = json_of_run_with(data_dir, "source --check --device pocl:0 --json");
    const cJSON *kernels = json_field(o, "kernels");
    assert_int_equal(json_number(item_named(kernels, "plain"), "compiled"), 15);
    assert_int_equal(json_number(item_named(kernels, "plain"), "failed"), 0);
    assert_int_equal(json_number(item_named(kernels, "shaped"), "compiled"), 2);
    program p = program_run_with(data_dir, "source --check plain --device pocl:0 --most 3");
    assert_string_equal(p.out, "plain                3 of 15 configs compiled\n");
}

static void write_kernel(const char *dir, const char *file, const char *chars)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", dir, file);
    test_write_file(path, chars);
}

TEST(what_does_not_compile_is_told_with_our_file_and_line)
{
    char dir[64], variables[96];
    test_make_folder(dir);
    write_kernel(dir, "common.clh", "// shared\n");
    write_kernel(dir, "bad.lua",
                 "return {\n  params = { { 'A', values = { 1, 2 } } },\n"
                 "  launch = function() return { group = 1, per_item = 1 } end,\n}\n");
    write_kernel(dir, "bad.cl.in",
                 "//@ if A == 2 then\n//@ end\n__kernel void bad(__global int *x)\n{\n"
                 "    x[0] = A == @{A} ? y : 0;\n}\n");
    snprintf(variables, sizeof variables, "DUET_KERNEL_DIR=%s", dir);
    program p = program_run_with(variables, "source --check --device pocl:0");
    assert_int_equal(p.exit_code, 1);
    assert_says(p.out, "0 of 2 configs compiled, 2 failed");
    assert_says(p.err, "duet: bad.A1 on pocl:0: ");
    char place[96];
    snprintf(place, sizeof place, "%s/bad.cl.in:5:", dir);
    assert_says(p.err, place, "duet: 2 configs failed to compile on pocl:0\n");
}

TEST(wrong_usage_is_one_line)
{
    static const program_refusal wrong[] = {
        {"source", 2, "KERNEL is missing"},
        {"source --list --check", 2, "--check and --list do not go together"},
        {"source --list --set WG=1", 2, "--set and --list do not go together"},
        {"source scan --set WG=x", 2, "--set 'WG=x': give a whole number"},
        {"source scan --set WG=", 2, "give a whole number"},
        {"source scan --set WG=99999999999999999999", 2, "give a whole number"},
        {"source scan --set GW=1", 2, "no parameter 'GW': there are WG, PER_ITEM"},
        {"source scan --set WG=3", 2, "WG=3 is not one of 1, 64, 128, 256"},
        {"source scam", 2, "no kernel 'scam'; did you mean 'scan'?"},
        {"source nosuch --list", 2, "no kernel 'nosuch'; 'duet source --list' lists those there"},
        {"source scan --device abacus:0", 2, "no device 'abacus:0'"},
    };
    program_assert_refusals("", "", wrong);
}

TEST_BEGIN(find_data)
