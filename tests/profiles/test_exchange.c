// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "profiles/exchange.h"
#include "profiles/sql.h"
#include "profiles/t4.h"
#include "profiles/upkeep.h"
#include "support/json.h"
#include "support/store.h"

#include <sys/wait.h>

typedef struct two_stores {
    test_folder folder;
    char other_path[96];
    store *s;
    store *other;
} two_stores;

static two_stores open_two(void)
{
    two_stores two = {.folder = test_folder_make()};
    snprintf(two.other_path, sizeof two.other_path, "%s/other.db", two.folder.path);
    two.s = kept(store_open(two.folder.store, STORE_WRITE, ERR));
    two.other = kept(store_open(two.other_path, STORE_WRITE, ERR));
    return two;
}

// Returns what an export of the store writes, which the test keeps.
static char *written_by(bool (*export)(store *, FILE *, const char *, duet_error *), store *s)
{
    char *chars = NULL;
    size_t n = 0;
    FILE *out = open_memstream(&chars, &n);
    must(export(s, out, "an export", ERR));
    fclose(out);
    return test_keep(chars, free);
}

static char *lines_of(store *s)
{
    return written_by(profile_export, s);
}

static bool import_lines(store *s, const char *lines, profile_import_counts *counts,
                         duet_error *err)
{
    FILE *in = fmemopen((char *)lines, strlen(lines), "r");
    assert_non_null(in);
    bool ok = profile_import(s, in, "rows.jsonl", counts, err);
    fclose(in);
    return ok;
}

static void tune_one(store *s, uint64_t n)
{
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(n);
    test_tune(s, &pair, &workload);
}

// The first has a tuning.
static two_stores open_tuned(void)
{
    two_stores two = open_two();
    tune_one(two.s, 1000);
    return two;
}

// All that the first has comes into the second.
static profile_import_counts bring_over(const two_stores *two)
{
    profile_import_counts counts;
    must(import_lines(two->other, lines_of(two->s), &counts, ERR));
    return counts;
}

TEST(what_went_out_comes_in_as_it_was)
{
    two_stores two = open_tuned();
    tune_one(two.s, 2000);
    test_fill_out(two.s);
    assert_int_equal(bring_over(&two).known, 0);
    assert_int_equal(test_count(two.other, "level_cost WHERE missed = 3 AND invented = 9"), 1);
    assert_string_equal(lines_of(two.other), lines_of(two.s));
    assert_int_equal(test_count(two.other, "fit"), test_count(two.s, "fit"));
    assert_int_equal(test_count(two.other, "sample"), 2 * 9 * 4);
}

TEST(numbers_of_full_length_survive)
{
    two_stores two = open_tuned();
    must(sql_script(two.s,
                    "UPDATE session SET seed = 9223372036854775807; "
                    "UPDATE sample SET at_ns = 1763710000123456789",
                    ERR));
    bring_over(&two);
    assert_int_equal(test_count(two.other, "session WHERE seed = 9223372036854775807"), 1);
    assert_int_equal(test_count(two.other, "sample WHERE at_ns <> 1763710000123456789"), 0);
}

static char *replaced(const char *lines, const char *from, const char *to)
{
    const char *at = strstr(lines, from);
    if (!at)
        fail_msg("no line has %s", from);
    text t = {0};
    text_add_bytes(&t, lines, (size_t)(at - lines));
    text_add(&t, "%s%s", to, at + strlen(from));
    return test_keep(t.chars, free);
}

// Versions before the fourth loaded plans without a verdict.
TEST(a_plan_without_a_verdict_comes_in_unused)
{
    two_stores two = open_tuned();
    char *lines = replaced(lines_of(two.s), "\"verdict\":\"faster\"", "\"verdict\":\"ambiguous\"");
    profile_import_counts counts;
    must(import_lines(two.other, lines, &counts, ERR));
    assert_int_equal(test_count(two.other, "profile WHERE live = 0 AND dead_reason = "
                                           "'" PROFILE_TOO_FEW_ROUNDS "'"),
                     1);
}

TEST(rows_that_are_known_are_not_taken_twice)
{
    two_stores two = open_tuned();
    profile_import_counts counts;
    must(import_lines(two.s, lines_of(two.s), &counts, ERR));
    assert_int_equal(counts.added, 0);
    assert_true(counts.known > 9);
    assert_int_equal(test_count(two.s, "profile"), 1);
    assert_int_equal(test_count(two.s, "sample"), 36);
}

TEST(a_file_without_lines_is_refused)
{
    two_stores two = open_two();
    profile_import_counts counts;
    static const char *const empty[] = {"", "\n \n"};
    for (size_t i = 0; i < sizeof empty / sizeof *empty; ++i)
        must_fail(import_lines(two.s, empty[i], &counts, ERR), DUET_STATUS_BAD_INPUT,
                  "rows.jsonl: is empty; expected what");
}

static int line_of(const char *lines, const char *what)
{
    int line = 1;
    for (const char *at = strstr(lines, what); at > lines; --at)
        line += at[-1] == '\n';
    return line;
}

// Each spoils one line of a good export; the message names it and nothing of
// the file is kept.
TEST(one_bad_line_refuses_the_file_and_is_named)
{
    static const struct {
        const char *from;
        const char *to;
        const char *says;
    } spoilt[] = {
        {"\"type\":\"pair\"", "\"type\":\"pear\"", "pear"},
        {"\"type\":\"trial\"", "\"type\"", "not a JSON object"},
        {"{\"type\":\"workload\"", "[{\"type\":\"workload\"", "not a JSON object"},
        {"\"share\":8192", "\"share\":70000", "share"},
        {"\"share\":8192", "\"share\":\"x\"", "share"},
        {"\"share\":8192", "\"chair\":8192", "share"},
        {"\"verdict\":\"faster\"", "\"verdict\":\"best\"", "verdict"},
        {"\"gain\":", "\"gains\":", "gains"},
        {"\"invalidity\":\"correct\"", "\"invalidity\":\"?\"", "outcome"},
        {"\"vendor\":\"NVIDIA Corporation\"", "\"vendor\":\"NVIDIA Co\"", "key"},
        {"\"driver\":\"3.1\"", "\"driver\":\"3.2\"", "key"},
        {"\"n\":1000,", "\"n\":1001,", "key"},
        {"\"uid\":", "\"kernels\":7,\"uid\":", "kernels"},
        {"\"options\":{", "\"options\":[{", "not a JSON object"},
        {"\"options\":{\"launches\":16}", "\"options\":\"{\\\"x\\\":1},\\\"evil\\\":{}\"",
         "JSON object: options"},
        {"\"terms\":null,\"rounds\"",
         "\"terms\":\"{\\\"x\\\":1},\\\"evil\\\":{\\\"a\\\":2}\",\"rounds\"", "JSON object: terms"},
        {"\"terms\":{\"T_CPU1\":1.5},\"samples\"", "\"terms\":\"{}\",\"samples\"",
         "JSON object: terms"},
        {"\"terms\":null,\"rounds\"", "\"terms\":7,\"rounds\"", "JSON object: terms"},
        {"\"name\":\"", "\"name\":\"\xff", "not UTF-8"},
        {"\"type\":\"store\",\"version\":8", "\"type\":\"store\",\"version\":9", "another version"},
    };
    two_stores two = open_tuned();
    for (size_t i = 0; i < sizeof spoilt / sizeof spoilt[0]; ++i) {
        char *lines = lines_of(two.s);
        int line = line_of(lines, spoilt[i].from);
        lines = replaced(lines, spoilt[i].from, spoilt[i].to);
        profile_import_counts counts;
        duet_error err = {0};
        char place[32];
        snprintf(place, sizeof place, "rows.jsonl:%d: ", line);
        if (import_lines(two.other, lines, &counts, &err))
            fail_msg("taken in: %s", spoilt[i].to);
        assert_int_equal(err.status, DUET_STATUS_BAD_INPUT);
        if (strncmp(err.text, place, strlen(place)) != 0 || !strstr(err.text, spoilt[i].says))
            fail_msg("for %s at %s: %s", spoilt[i].to, place, err.text);
        assert_int_equal(test_count(two.other, "device"), 0);
        assert_int_equal(test_count(two.other, "audit"), 0);
    }
}

// A store that somebody tampered with goes out without what is no object.
TEST(a_poisoned_store_is_told_of_and_still_goes_out)
{
    two_stores two = open_tuned();
    own(text) report = {0};
    uint32_t problems = 0;
    must(sql_script(two.s,
                    "UPDATE profile SET terms = '{\"x\":1},\"evil\":{\"a\":2}';"
                    "UPDATE trial SET terms = '{broken}' WHERE number = 1;"
                    "UPDATE trial SET terms = '{\"fine\":0.1}' WHERE number = 2;"
                    "UPDATE session SET options = '{} , {}'",
                    ERR));
    must(profile_check(two.s, &report, &problems, ERR));
    assert_int_equal(problems, 3);
    assert_says(text_chars(&report), "a profile's terms are no JSON object");
    char *lines = lines_of(two.s);
    assert_null(strstr(lines, "evil"));
    assert_null(strstr(lines, "broken"));
    assert_says(lines, "\"terms\":{\"fine\":0.1}");
    bring_over(&two);
    assert_int_equal(test_count(two.other, "profile"), 1);
}

TEST(a_row_whose_pair_is_nowhere_is_refused)
{
    two_stores two = open_tuned();
    char *session = strstr(lines_of(two.s), "{\"type\":\"session\"");
    assert_non_null(session);
    profile_import_counts counts;
    must_fail(import_lines(two.other, session, &counts, ERR), DUET_STATUS_BAD_INPUT,
              "rows.jsonl:1: needs a row");
    assert_says(ERR->text, "pair_id");
}

// A backslash before u0000 is none: that line is refused for its key, which comes from the name.
TEST(a_text_with_a_nul_is_refused)
{
    two_stores two = open_tuned();
    profile_import_counts counts;
    const char *lines = lines_of(two.s), *name = "\"name\":\"";
    must_fail(import_lines(two.other, replaced(lines, name, "\"name\":\"a\\u0000"), &counts, ERR),
              DUET_STATUS_BAD_INPUT, "has a string with a NUL");
    assert_int_equal(test_count(two.other, "profile"), 0);
    must_fail(import_lines(two.other, replaced(lines, name, "\"name\":\"a\\\\u0000"), &counts, ERR),
              DUET_STATUS_BAD_INPUT, "its key is not that of its fields");
}

// Whatever a line holds, the import ends with all rows or with one line of
// error, and the store stays sound.
TEST(spoilt_bytes_never_break_the_store)
{
    two_stores two = open_tuned();
    rng r = rng_seed(test_seed());
    int refused = 0;
    for (int round = 0; round < 150; ++round) {
        char *lines = lines_of(two.s);
        size_t n = strlen(lines);
        for (int i = 0; i < 3; ++i)
            lines[rng_below(&r, (uint32_t)n)] = (char)(1 + rng_below(&r, 255));
        profile_import_counts counts;
        duet_error err = {0};
        int64_t before = test_count(two.other, "audit");
        bool ok = import_lines(two.other, lines, &counts, &err);
        refused += !ok;
        assert_int_equal(test_count(two.other, "audit"), before + ok);
        assert_true(ok || strncmp(err.text, "rows.jsonl:", 11) == 0);
    }
    assert_true(refused > 50);
    own(text) report = {0};
    uint32_t problems = 0;
    must(profile_check(two.other, &report, &problems, ERR));
    assert_int_equal(problems, 0);
}

TEST(a_merge_keeps_two_machines_apart)
{
    two_stores two = open_two();
    profile_pair pair = test_pair();
    profile_pair theirs = test_pair();
    theirs.b.device.name = "NVIDIA H100";
    profile_workload workload = test_workload(1000);
    test_tune(two.s, &pair, &workload);
    test_tune(two.other, &theirs, &workload);
    must(sql_script(two.other, "UPDATE session SET host = 'elsewhere'", ERR));
    profile_import_counts counts;
    must(profile_merge(two.s, two.other_path, &counts, ERR));
    assert_int_equal(test_count(two.s, "profile WHERE live = 1"), 2);
    assert_int_equal(test_count(two.s, "device"), 3);
    assert_int_equal(test_count(two.s, "session WHERE host = 'elsewhere'"), 1);
    assert_int_equal(test_count(two.s, "fit WHERE host = 'elsewhere'"), 4);
    const profile_pair *pairs[] = {&pair, &theirs};
    char hosts[2][PROFILE_ID];
    for (int i = 0; i < 2; ++i) {
        profile_request request = test_request(pairs[i], &workload);
        profile_found found;
        must(profile_lookup(two.s, &request, &found, NULL, ERR));
        assert_int_equal(found.grade, PROFILE_EXACT);
        memcpy(hosts[i], found.session, sizeof hosts[i]);
    }
    assert_string_not_equal(hosts[0], hosts[1]);
}

TEST(a_merge_does_not_replace_the_stores_own_profile)
{
    two_stores two = open_tuned();
    tune_one(two.other, 1000);
    duet_error err = {0};
    sql q = sql_make(two.s, "SELECT uid FROM profile", &err);
    assert_true(sql_row(&q));
    char own[PROFILE_ID];
    sql_copy(own, sizeof own, sql_get_text(&q, 0));
    sql_close(&q);
    profile_import_counts counts;
    must(profile_merge(two.s, two.other_path, &counts, ERR));
    char query[96];
    snprintf(query, sizeof query, "profile WHERE live = 1 AND uid = '%s'", own);
    assert_int_equal(test_count(two.s, query), 1);
    assert_int_equal(
        test_count(two.s, "profile WHERE dead_reason = 'the store had one of its own'"), 1);
}

TEST(a_store_is_not_merged_into_itself)
{
    two_stores two = open_two();
    profile_import_counts counts;
    must_fail(profile_merge(two.s, two.folder.store, &counts, ERR), DUET_STATUS_BAD_ARGUMENT, "");
}

// ------------------------------------------------------------------- prune, check

TEST(pruning_thins_samples_and_keeps_medians)
{
    two_stores two = open_tuned();
    tune_one(two.s, 1000);
    profile_prune_def def = {.keep_samples = 2, .before_ns = INT64_MAX, .drop_dead = true};
    profile_prune_counts counts;
    must(profile_prune(two.s, &def, &counts, ERR));
    assert_int_equal(counts.samples, 2 * 9 * 2);
    assert_int_equal(counts.profiles, 1);
    assert_int_equal(test_count(two.s, "trial WHERE median_ns > 0 AND launches = 3"), 18);
    assert_int_equal(test_count(two.s, "sample"), 2 * 9 * 2);
    assert_int_equal(test_count(two.s, "sample WHERE number IN (0, 2)"), 2 * 9 * 2);
    def.keep_samples = 0;
    must(profile_prune(two.s, &def, &counts, ERR));
    assert_int_equal(test_count(two.s, "sample"), 0);
    assert_int_equal(test_count(two.s, "profile WHERE live = 1"), 1);
}

TEST(pruning_leaves_an_unfinished_search_whole)
{
    two_stores two = open_tuned();
    must(sql_script(two.s, "UPDATE session SET state = 'stopped'", ERR));
    profile_prune_def def = {.keep_samples = 0, .before_ns = INT64_MAX};
    profile_prune_counts counts;
    must(profile_prune(two.s, &def, &counts, ERR));
    assert_int_equal(counts.samples, 0);
}

TEST(a_check_finds_what_was_tampered_with)
{
    static const refusal cases[] = {
        {"UPDATE device SET name = 'another' WHERE kind = 'gpu'", "device "},
        {"UPDATE env SET seat = 'x'", "env "},
        {"UPDATE workload SET n = n + 1", "workload "},
        {"UPDATE workload SET size_ratio = 0", "workload "},
        {"UPDATE profile SET trial = 99", "trial is not there"},
        {"PRAGMA foreign_keys = OFF; DELETE FROM workload", "points at none"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        two_stores two = open_tuned();
        own(text) report = {0};
        uint32_t problems = 0;
        must(profile_check(two.s, &report, &problems, ERR));
        assert_int_equal(problems, 0);
        must(sql_script(two.s, cases[i].given, ERR));
        must(profile_check(two.s, &report, &problems, ERR));
        assert_true(problems > 0);
        assert_says(text_chars(&report), cases[i].says);
    }
}

// ---------------------------------------------------------------- trials as a T4 document, which
// Kernel Tuner's own schema judges if that is installed

static const char *const failures[][2] = {
    {"build", "compile"},   {"launch", "runtime"},     {"wrong", "correctness"},
    {"timeout", "timeout"}, {"pruned", "constraints"},
};
enum { N_OK = 9, N_FAILURES = sizeof failures / sizeof *failures };

// Nine trials that ran, and one for each way in which a trial fails.
static store *make_store(const test_folder *folder)
{
    store *s = test_store_open(folder->store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    workload.name = "a \"scene\"\n";
    test_tune(s, &pair, &workload);
    profile_session session = test_session(1, 1);
    char id[PROFILE_ID];
    must(profile_session_begin(s, &session, id, ERR));
    for (int i = 0; i < N_FAILURES; ++i) {
        profile_trial trial = {
            .plan = test_plan(0.5), .outcome = failures[i][0], .reason = "it did not run"};
        trial.scope = PROFILE_SHARE_ONE;
        must(profile_trial_add(s, id, i, &trial, ERR));
    }
    return s;
}

static cJSON *document_of(store *s)
{
    return json_of(written_by(profile_export_t4, s));
}

TEST(every_trial_is_a_result_that_says_whether_it_is_correct)
{
    test_folder folder = test_folder_make();
    store *s = make_store(&folder);
    cJSON *document = document_of(s);
    const cJSON *results = json_array(document, "results", N_OK + N_FAILURES);
    for (int i = 0; i < N_OK + N_FAILURES; ++i) {
        const cJSON *result = cJSON_GetArrayItem(results, i);
        bool ok = i < N_OK;
        const cJSON *times = json_field(result, "times");
        assert_string_equal(json_string(result, "invalidity"),
                            ok ? "correct" : failures[i - N_OK][1]);
        assert_int_equal(json_number(result, "correctness"), ok);
        const cJSON *runtimes = json_array(times, "runtimes", ok ? 3 : 0);
        const cJSON *measured = json_array(result, "measurements", ok ? 6 : 0);
        if (!ok)
            continue;
        double median_ns = test_time(i < 2 ? 1 : 0, 1000, i / 8.0);
        const cJSON *median = cJSON_GetArrayItem(measured, 0);
        assert_string_equal(json_string(median, "name"), "median");
        assert_float_equal(json_number(median, "value"), median_ns * 1e-6, 1e-9);
        assert_float_equal(cJSON_GetArrayItem(runtimes, 0)->valuedouble, median_ns * 1e-6, 2e-6);
        assert_true(json_number(json_field(result, "configuration"), "share") == i / 8.0);
    }
    store_close(s);
}

TEST(a_failure_comes_back_as_it_was)
{
    test_folder folder = test_folder_make();
    store *s = make_store(&folder), *other = test_store_fresh();
    profile_import_counts counts;
    must(import_lines(other, lines_of(s), &counts, ERR));
    for (int i = 0; i < N_FAILURES; ++i) {
        char query[64];
        snprintf(query, sizeof query, "trial WHERE outcome = '%s'", failures[i][0]);
        assert_int_equal(test_count(other, query), 1);
    }
    store_close(s);
}

TEST(a_store_without_trials_is_a_document_without_results)
{
    store *s = test_store_fresh();
    cJSON *document = document_of(s);
    json_array(document, "results", 0);
}

TEST(kernel_tuners_schema_finds_it_valid)
{
    char path[128], command[512];
    test_folder folder = test_folder_make();
    store *s = make_store(&folder);
    snprintf(path, sizeof path, "%s/t4.json", folder.path);
    must(profile_export_file(s, profile_export_t4, path, ERR));
    snprintf(command, sizeof command, "python3 '%s/../profiles/t4.py' '%s'",
             getenv("DUET_TEST_DATA"), path);
    int status = system(command);
    store_close(s);
    bool absent = WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127;
    if (absent) {
        print_message("no kernel-tuner here: its schema is not asked\n");
        skip();
    }
    assert_int_equal(status, 0);
}
