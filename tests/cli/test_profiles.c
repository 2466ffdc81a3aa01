// SPDX-License-Identifier: MIT
// duet profiles, as a person calls it.
#define _POSIX_C_SOURCE 200809L
#include "profiles/sql.h"

#include "base/text_file.h"
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

// A store with two profiles, one of them replaced once.
static test_folder make_store(void)
{
    test_folder folder = test_folder_make();
    store *s = must(store_open(folder.store, STORE_WRITE, ERR));
    profile_pair pair = test_pair();
    profile_workload small = test_workload(1000);
    profile_workload large = test_workload(250000);
    test_tune(s, &pair, &small);
    test_tune(s, &pair, &large);
    test_tune(s, &pair, &large);
    store_close(s);
    return folder;
}

static program run_on(const test_folder *folder, const char *arguments)
{
    return program_run_with(folder->variable, "profiles %s", arguments);
}

static cJSON *run_json(const test_folder *folder, const char *arguments)
{
    program p = run_on(folder, arguments);
    return json_of_program(p);
}

static void assert_prints(const test_folder *folder, const char *arguments, const char *says)
{
    program p = program_done(run_on(folder, arguments));
    assert_string_equal(p.err, "");
    if (*says && !strstr(p.out, says))
        fail_msg("profiles %s does not say '%s':\n%s", arguments, says, p.out);
}

static void assert_refused(const test_folder *folder, const char *arguments, int code,
                           const char *says)
{
    program_assert_refused(run_on(folder, arguments), code, says);
}

TEST(list_shows_what_an_application_would_load)
{
    test_folder folder = make_store();
    cJSON *o = run_json(&folder, "list --json");
    const cJSON *profiles = json_array(o, "profiles", 2);
    const cJSON *large = cJSON_GetArrayItem(profiles, 1);
    assert_int_equal(json_number(large, "objects"), 250000);
    assert_true(json_number(large, "share") == 0.125);
    assert_true(json_number(large, "gain") == 0.12);
    assert_string_equal(json_string(large, "verdict"), "faster");
    assert_string_equal(json_string(large, "mode"), "own");
    assert_string_equal(json_string(json_field(large, "b"), "name"), "NVIDIA H200");
    o = run_json(&folder, "list --dead --json");
    json_array(o, "profiles", 3);
    assert_prints(&folder, "list", "A: pthread-AMD EPYC 7763 64-Core Processor [0-0], driver 3.1");
    assert_prints(&folder, "list", "250 000");
    assert_prints(&folder, "list --dead", "replaced by a later tuning");
    program p = run_on(&folder, "list");
    for (const char *line = p.out; *line; line += strcspn(line, "\n") + 1)
        assert_in_range(strcspn(line, "\n"), 0, 80);
}

TEST(show_gives_a_profile_with_its_trials)
{
    test_folder folder = make_store();
    cJSON *all = run_json(&folder, "list --json");
    const cJSON *first = json_row(all, "profiles", 0);
    char arguments[96];
    snprintf(arguments, sizeof arguments, "show %.12s --json", json_string(first, "uid"));
    cJSON *o = run_json(&folder, arguments);
    const cJSON *trials = json_array(o, "trials", 9);
    assert_string_equal(json_string(o, "uid"), json_string(first, "uid"));
    assert_true(json_number(cJSON_GetArrayItem(trials, 8), "share") == 1);
    const cJSON *session = json_field(o, "session");
    assert_string_equal(json_string(session, "strategy"), "balance");
    assert_string_equal(json_string(session, "script"), "return { n = 1000 }");
    assert_int_equal(json_number(session, "launches"), 27);
    snprintf(arguments, sizeof arguments, "show %.12s", json_string(first, "uid"));
    assert_prints(&folder, arguments, "gain      +12.0 % (+10.0 to +14.0)");
    assert_prints(&folder, arguments, "search    balance, seed 1, 9 trials, 27 launches");
    assert_refused(&folder, "show zz", 2, "no profile begins with 'zz'");
    assert_refused(&folder, "show ''", 2, "3 profiles begin with ''");
}

TEST(a_profile_that_was_measured_beside_others_is_told_as_such)
{
    test_folder folder = make_store();
    char arguments[64], note[96];
    program quiet = run_on(&folder, "list");
    assert_null(strstr(quiet.out, "waited for a core"));
    test_store_run(folder.store, "UPDATE profile SET watched = 430, disturbed = 300 WHERE id = 1");
    cJSON *o = run_json(&folder, "list --json");
    const cJSON *first = cJSON_GetArrayItem(json_array(o, "profiles", 2), 0);
    assert_int_equal(json_number(first, "disturbed"), 300);
    snprintf(note, sizeof note, "\n%.8s: 300 of 430 launches waited for a core\n",
             json_string(first, "uid"));
    assert_prints(&folder, "list", note);
    snprintf(arguments, sizeof arguments, "show %s", json_string(first, "uid"));
    assert_prints(&folder, arguments, "quiet     300 of 430 launches waited for a core");
}

// Profiles of one workload for two numbers of ranks, and one for energy.
TEST(a_profile_that_is_not_of_plain_time_says_of_which)
{
    static const char ranks[] = "time over 2 ranks of 1 part on 1 host";
    test_folder folder = make_store();
    program plain = run_on(&folder, "list");
    assert_null(strstr(plain.out, "tuned for"));
    test_store_run(folder.store, "UPDATE profile SET objective = 'energy' WHERE id = 1;"
                                 "UPDATE profile SET objective = 'time over 2 ranks of 1 part on 1 "
                                 "host' WHERE id <> 1");
    cJSON *o = run_json(&folder, "list --json");
    for (int i = 0; i < 2; ++i) {
        const char *uid = json_string(cJSON_GetArrayItem(json_array(o, "profiles", 2), i), "uid");
        const char *objective = i == 0 ? "energy" : ranks;
        char arguments[64], note[96], row[96];
        snprintf(note, sizeof note, "\n%.8s: tuned for %s\n", uid, objective);
        assert_prints(&folder, "list", note);
        snprintf(arguments, sizeof arguments, "show %s", uid);
        snprintf(row, sizeof row, "\ntuned     for %s\n", objective);
        assert_prints(&folder, arguments, row);
    }
}

// The store's third profile is dead, of 250 000 objects.
TEST(a_stored_profile_is_compared_put_to_use_and_forgotten)
{
    test_folder folder = make_store();
    char uids[3][40];
    char arguments[160];
    cJSON *o = run_json(&folder, "list --dead --json");
    for (int i = 0; i < 3; ++i)
        snprintf(uids[i], sizeof uids[i], "%s",
                 json_string(cJSON_GetArrayItem(json_array(o, "profiles", 3), i), "uid"));
    snprintf(arguments, sizeof arguments, "diff %s %s", uids[1], uids[2]);
    assert_prints(&folder, arguments, "replaced by a later tuning");
    assert_prints(&folder, arguments, "0.0 % longer than one of");
    snprintf(arguments, sizeof arguments, "diff %s %s", uids[0], uids[2]);
    assert_prints(&folder, arguments, "Their workloads differ");
    snprintf(arguments, sizeof arguments, "diff %s %s --json", uids[1], uids[2]);
    o = run_json(&folder, arguments);
    assert_true(json_true(json_field(o, "first"), "live"));
    assert_string_equal(json_string(json_field(o, "second"), "uid"), uids[2]);
    snprintf(arguments, sizeof arguments, "use %.9s", uids[2]);
    assert_prints(&folder, arguments, "");
    o = run_json(&folder, "list --json");
    assert_string_equal(json_string(cJSON_GetArrayItem(json_array(o, "profiles", 2), 1), "uid"),
                        uids[2]);
    snprintf(arguments, sizeof arguments, "forget %s", uids[2]);
    assert_prints(&folder, arguments, "");
    assert_refused(&folder, arguments, 2, "no profile begins with");
    assert_prints(&folder, "list --dead", "another was put to use");
    snprintf(arguments, sizeof arguments, "forget %s", uids[0]);
    assert_prints(&folder, arguments, "");
    assert_prints(&folder, "list", "no profile is in use; --dead shows the 1 that is not");
    assert_refused(&folder, "diff 1", 2, "PROFILE PROFILE is missing");
}

static void assert_null_figures(const cJSON *o, const char *const *names, int n)
{
    for (int i = 0; i < n; ++i)
        if (!cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(o, names[i])))
            fail_msg("'%s' is not null", names[i]);
}

TEST(a_figure_that_was_not_measured_is_null)
{
    static const char *const figures[] = {"whole_ms",        "whole_gain", "whole_gain_low",
                                          "whole_gain_high", "single_ms",  "missed_rate",
                                          "false_rate",      "true_pairs"};
    static const char *const times[] = {"ms", "low_ms", "high_ms", "a_ms", "b_ms"};
    test_folder folder = make_store();
    char arguments[96];
    test_store_run(folder.store,
                   "UPDATE profile SET whole_ns = NULL, whole_gain = NULL, whole_gain_low = NULL, "
                   "whole_gain_high = NULL, single_ns = NULL, true_pairs = NULL;"
                   "UPDATE trial SET outcome = 'build', reason = 'no such kernel', "
                   "median_ns = NULL, mad_ns = NULL, low_ns = NULL, high_ns = NULL, a_ns = NULL, "
                   "b_ns = NULL WHERE number = 1");
    cJSON *all = run_json(&folder, "list --json");
    const cJSON *first = cJSON_GetArrayItem(json_array(all, "profiles", 2), 0);
    assert_null_figures(first, figures, sizeof figures / sizeof *figures);
    snprintf(arguments, sizeof arguments, "show %s --json", json_string(first, "uid"));
    cJSON *o = run_json(&folder, arguments);
    assert_null_figures(cJSON_GetArrayItem(json_array(o, "trials", 9), 1), times, 5);
    snprintf(arguments, sizeof arguments, "show %s", json_string(first, "uid"));
    program p = run_on(&folder, arguments);
    assert_null(strstr(p.out, "nan"));
}

// A row of one device says which, and what sharing would do; not the gain of a plan that
// is not used.
TEST(what_one_device_does_alone_is_told_as_such)
{
    test_folder folder = make_store();
    duet_error err = {0};
    char arguments[64];
    store *s = store_open(folder.store, STORE_WRITE, &err);
    must(s && sql_script(s,
                         "UPDATE profile SET share = 0, gain = -0.261, gain_low = -0.3, "
                         "gain_high = -0.2, verdict = 'slower', whole_ns = 1e6, "
                         "whole_gain = -0.2, whole_gain_low = -0.25, whole_gain_high = -0.1",
                         ERR));
    store_close(s);
    cJSON *o = run_json(&folder, "list --json");
    const cJSON *first = cJSON_GetArrayItem(json_array(o, "profiles", 2), 0);
    snprintf(arguments, sizeof arguments, "show %s", json_string(first, "uid"));
    assert_prints(&folder, arguments, "B alone; sharing would be 26.1 % slower (20.0 to 30.0)");
    assert_prints(&folder, arguments, "by itself is 25.0 % faster (11.1 to 33.3): use --pair with");
    assert_prints(&folder, "list", "B alone");
    assert_prints(&folder, "list", "by itself is 25.0 % faster");
    test_store_run(folder.store, "UPDATE profile SET objective = 'energy'");
    assert_prints(&folder, arguments, "sharing would take 35.3 % more energy (25.0 to 42.9)");
}

// The store tells two cards of one model not apart, but what shares is no single device.
TEST(two_equal_devices_that_share_are_two)
{
    test_folder folder = make_store();
    char arguments[64];
    test_store_run(folder.store, "UPDATE pair SET env_b = env_a; UPDATE profile SET share = 32768");
    cJSON *o = run_json(&folder, "list --json");
    const cJSON *first = cJSON_GetArrayItem(json_array(o, "profiles", 2), 0);
    snprintf(arguments, sizeof arguments, "show %s", json_string(first, "uid"));
    assert_prints(&folder, arguments, "share 0.50000");
    assert_prints(&folder, "list", "\nB: ");
}

TEST(rows_go_out_and_into_another_store)
{
    test_folder folder = make_store();
    test_folder other = test_folder_make();
    char arguments[160];
    snprintf(arguments, sizeof arguments, "export %s/rows.jsonl", folder.path);
    program p = program_done(run_on(&folder, arguments));
    assert_string_equal(p.out, "");
    snprintf(arguments, sizeof arguments, "import %s/rows.jsonl --json", folder.path);
    cJSON *o = run_json(&other, arguments);
    assert_int_equal(json_number(o, "known"), 0);
    double added = json_number(o, "added");
    snprintf(arguments, sizeof arguments, "merge %s --json", folder.store);
    o = run_json(&other, arguments);
    assert_int_equal(json_number(o, "added"), 0);
    assert_true(json_number(o, "known") == added);
    snprintf(arguments, sizeof arguments, "export | cmp - %s/rows.jsonl", folder.path);
    program_done(run_on(&other, arguments));
    snprintf(arguments, sizeof arguments, "export %s", folder.store);
    program_assert_refused(run_on(&folder, arguments), 2,
                           ": is the store itself; name another one");
    program_done(run_on(&folder, "export"));
}

TEST(a_bad_line_is_named_and_the_store_untouched)
{
    test_folder folder = make_store();
    test_folder other = test_folder_make();
    char arguments[256];
    snprintf(arguments, sizeof arguments,
             "export | sed '4s/\"type\"/\"tpye\"/' >%s/rows.jsonl; true", folder.path);
    run_on(&folder, arguments);
    snprintf(arguments, sizeof arguments, "import %s/rows.jsonl", folder.path);
    char says[128];
    snprintf(says, sizeof says, "%s/rows.jsonl:4: its type is not one of", folder.path);
    assert_refused(&other, arguments, 1, says);
    cJSON *o = run_json(&other, "list --json");
    json_array(o, "profiles", 0);
}

TEST(prune_and_check_say_what_they_found)
{
    test_folder folder = make_store();
    cJSON *o = run_json(&folder, "prune --samples 1 --dead --json");
    assert_int_equal(json_number(o, "samples"), 27 * 3);
    assert_int_equal(json_number(o, "profiles"), 1);
    assert_prints(&folder, "prune", "0 launches and 0 profiles forgotten");
    o = run_json(&folder, "check --json");
    json_array(o, "problems", 0);
    assert_prints(&folder, "check", "sound");
    duet_error err = {0};
    store *s = store_open(folder.store, STORE_WRITE, &err);
    must(s && sql_script(s, "UPDATE device SET units = 7", ERR));
    store_close(s);
    program p = run_on(&folder, "check");
    assert_int_equal(p.exit_code, 1);
    assert_says(p.out, "its key is not that of its fields");
    assert_says(p.err, "rows are not sound");
}

TEST(what_is_wrong_is_said_in_one_line)
{
    test_folder folder = test_folder_make();
    assert_refused(&folder, "", 2, "what to do is missing: give one of list, show,");
    assert_refused(&folder, "juggle", 2, "there is no 'juggle': give one of list, show,");
    assert_refused(&folder, "list extra", 2, "unexpected argument 'extra'");
    assert_refused(&folder, "import", 2, "FILE|- is missing");
    assert_refused(&folder, "prune --samples -1", 2, "--samples");
    assert_refused(&folder, "list", 1, "there is no profile store; duet tune makes one");
    assert_refused(&folder, "import no/such.jsonl", 1, "no/such.jsonl: No such file");
    must(text_write_file(folder.store, "rubbish", 7, ERR));
    assert_refused(&folder, "list", 1, "is not a profile store and was left as it is");
    assert_refused(&folder, "prune", 1, "is not a profile store and was left as it is");
}

// The queries that docs/store.md shows, each run on a store.
TEST(every_query_of_the_documentation_works)
{
    test_folder folder = make_store();
    duet_error err = {0};
    store *s = kept(store_open(folder.store, STORE_WRITE, ERR));
    own(text) path = {0};
    text_add(&path, "%s/../../docs/store.md", getenv("DUET_TEST_DATA"));
    const text doc = test_read_file(text_chars(&path));
    int n = 0;
    for (char *at = doc.chars; (at = strstr(at, "```sql\n")); ++n) {
        at += strlen("```sql\n");
        char *end = strstr(at, "```");
        assert_non_null(end);
        *end = '\0';
        sql q = sql_make(s, at, &err);
        bool some = sql_row(&q);
        if (!sql_close(&q))
            fail_msg("%s", err.text);
        // All trials of the store worked and its workloads are small.
        if (!some && !strstr(at, "outcome <> 'ok'") && !strstr(at, "w.n = 1000000"))
            fail_msg("no row for %s", at);
        at = end + 1;
    }
    assert_true(n >= 5);
}
