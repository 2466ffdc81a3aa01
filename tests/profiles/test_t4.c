// SPDX-License-Identifier: MIT
// Trials as a T4 document. Kernel Tuner's own schema judges it where that is installed.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "profiles/exchange.h"
#include "profiles/t4.h"
#include "support/json.h"
#include "support/store.h"

#include <sys/wait.h>

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
    char *chars = NULL;
    size_t n = 0;
    FILE *out = open_memstream(&chars, &n);
    must(profile_export_t4(s, out, "a document", ERR));
    fclose(out);
    cJSON *document = json_of(chars);
    free(chars);
    return document;
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
        const cJSON *times = cJSON_GetObjectItem(result, "times");
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
        assert_true(json_number(cJSON_GetObjectItem(result, "configuration"), "share") == i / 8.0);
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

TEST_MAIN(NULL, NULL)
