// SPDX-License-Identifier: MIT
// duet tune --replay, as a person calls it on a machine without devices.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

#define NO_DEVICE "OCL_ICD_VENDORS=/nowhere"

static test_folder folder;

static void make_store(void)
{
    folder = test_folder_make();
    program_done(program_run_with("gzip -dc \"$DUET_TEST_DATA\"/surfaces.jsonl.gz |",
                                  "profiles import - --profile %s", folder.store));
}

static program replay(const char *arguments)
{
    return program_run_with(NO_DEVICE, "tune --replay %s %s", folder.store, arguments);
}

TEST(every_workload_and_strategy_is_replayed_without_a_device)
{
    program p = replay("--json");
    cJSON *o = json_of_program(p);
    const cJSON *workload;
    cJSON_ArrayForEach(workload, json_array(o, "workloads", 2))
    {
        const cJSON *row;
        assert_string_equal(json_string(workload, "scene"), "paper");
        assert_true(json_number(workload, "plans") > 90);
        cJSON_ArrayForEach(row, json_array(workload, "strategies", 4))
        {
            double ms = json_number(row, "ms"), best_ms = json_number(workload, "best_ms");
            assert_true(fabs(json_number(row, "loss") - (ms / best_ms - 1)) < 1e-9);
            assert_true(json_number(row, "loss") <= json_number(row, "worst_loss"));
            assert_true(json_number(row, "search_launches") < json_number(row, "launches"));
            assert_true(json_number(row, "seconds") > 0);
        }
    }
}

TEST(a_seed_a_scene_and_a_strategy_are_chosen)
{
    static const char chosen[] = "paper -n 20k --strategy balance --json --seed 3";
    program first = replay(chosen), again = replay(chosen);
    assert_string_equal(first.out, again.out);
    cJSON *o = json_of_program(first);
    assert_int_equal(json_number(o, "seed"), 3);
    const cJSON *workload = cJSON_GetArrayItem(json_array(o, "workloads", 1), 0);
    assert_int_equal(json_number(workload, "objects"), 20000);
    const cJSON *row = cJSON_GetArrayItem(json_array(workload, "strategies", 1), 0);
    assert_string_equal(json_string(row, "strategy"), "balance");
}

TEST(a_script_is_replayed_as_a_strategy)
{
    char script[128], arguments[192];
    snprintf(script, sizeof script, "%s/half.lua", folder.path);
    test_write_file(script, "return function(history)\n"
                            "  if #history < 2 then return #history / 2 end\nend\n");
    snprintf(arguments, sizeof arguments, "-n 20000 --json --strategy-lua %s", script);
    program p = replay(arguments);
    cJSON *o = json_of_program(p);
    const cJSON *workload = cJSON_GetArrayItem(json_array(o, "workloads", 1), 0);
    const cJSON *row = cJSON_GetArrayItem(json_array(workload, "strategies", 1), 0);
    assert_string_equal(json_string(row, "strategy"), "lua");
    assert_int_equal(json_number(row, "search_launches"), 3 * 2 * (1 + 3)); // modes, shares
}

TEST(the_table_fits_a_terminal)
{
    program p = program_done(replay("-n 100000"));
    assert_says(p.out, "paper, 100 000\nA: ");
    for (const char *at = p.out; *at; at += strcspn(at, "\n") + 1)
        assert_in_range(strcspn(at, "\n"), 0, 80);
}

TEST(what_cannot_be_replayed_is_said_in_a_line)
{
    program_assert_refused(replay("clustered"), 2,
                           "does not have that workload; it has paper -n 20000, paper -n");
    program_assert_refused(replay("--fresh"), 2, "--fresh and --replay do not go together");
    program p = replay("--strategy best");
    assert_true(p.exit_code > 0);
    assert_says(p.err, "strategy 'best': there is none; there are balance, fig12");
    program_assert_refused(replay("--strategy annealing"), 1,
                           "has no workload for that strategy; expected shares that");
    program_assert_refused(program_run("tune --replay /nowhere/profiles.db"), 1,
                           "/nowhere/profiles.db: ");
    test_folder empty = test_folder_make();
    store_close(test_store_open(empty.store, STORE_WRITE));
    program_assert_refused(program_run("tune --replay %s", empty.store), 1,
                           "no workload's shares were all measured; expected one that");
}

TEST_BEGIN(make_store)
