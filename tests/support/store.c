// SPDX-License-Identifier: MIT
#include "support/store.h"

#include "profiles/sql.h"
#include "support/test.h"

test_folder test_folder_make(void)
{
    test_folder folder;
    test_make_folder(folder.path);
    snprintf(folder.store, sizeof folder.store, "%s/profiles.db", folder.path);
    snprintf(folder.variable, sizeof folder.variable, "DUET_PROFILE=%s", folder.store);
    return folder;
}

store *test_store_open(const char *path, store_access access)
{
    return must(store_open(path, access, ERR));
}

store *test_store_fresh(void)
{
    return kept(store_open(test_folder_make().store, STORE_WRITE, ERR));
}

store *test_store_tuned(void)
{
    store *s = test_store_fresh();
    test_tune_usual(s);
    return s;
}

void test_store_refuses(const char *path, store_access access, duet_status status, const char *says)
{
    must_fail(store_open(path, access, ERR), status, says);
    assert_non_null(strstr(ERR->text, path));
}

void test_store_run(const char *path, const char *statements)
{
    sqlite3 *db = NULL;
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, statements, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}

profile_pair test_pair(void)
{
    return (profile_pair){
        .a = {.device = {.kind = "cpu",
                         .vendor = "AuthenticAMD",
                         .name = "pthread-AMD EPYC 7763 64-Core Processor",
                         .units = 2,
                         .max_group = 4096,
                         .local_bytes = 524288,
                         .global_bytes = 8589934592},
              .platform = "Portable Computing Language",
              .platform_version = "OpenCL 3.0 PoCL 3.1",
              .driver = "3.1",
              .cl_version = "OpenCL 3.0",
              .part = "0-0",
              .part_units = 1},
        .b = {.device = {.kind = "gpu",
                         .vendor = "NVIDIA Corporation",
                         .name = "NVIDIA H200",
                         .units = 132,
                         .max_group = 1024,
                         .local_bytes = 49152,
                         .global_bytes = 150000000000},
              .platform = "NVIDIA CUDA",
              .platform_version = "OpenCL 3.0 CUDA 12.4",
              .driver = "550.54",
              .cl_version = "OpenCL 3.0"},
    };
}

profile_workload test_workload(uint64_t n)
{
    uint32_t edge = (uint32_t)lround(cbrt((double)n / 0.66));
    return (profile_workload){
        .dims = 3,
        .n = n,
        .cells = {edge, edge, edge},
        .cell = sqrt(3),
        .occ_mean = 0.66,
        .occ_p99 = 3,
        .size_ratio = 1,
        .shape = "poses",
        .rotated = true,
        .level = "certified",
        .name = "paper",
    };
}

profile_session test_session(int64_t pair_id, int64_t workload_id)
{
    return (profile_session){
        .pair_id = pair_id,
        .workload_id = workload_id,
        .kernels = TEST_KERNELS,
        .strategy = "balance",
        .objective = "time",
        .options = "{\"launches\":16}",
        .seed = 1,
        .script = "return { n = 1000 }",
        .tool_version = "0.9.0",
        .load = 0.5,
        .timer_ns = 30,
    };
}

profile_plan test_plan(double share)
{
    return (profile_plan){
        .share = (uint32_t)lround(share * PROFILE_SHARE_ONE),
        .mode = "own",
        .level = "certified",
        .variant_a = "auto",
        .variant_b = "auto sort=radix",
    };
}

profile_request test_request(const profile_pair *pair, const profile_workload *workload)
{
    profile_request request = profile_default_request();
    request.pair = pair;
    request.workload = workload;
    request.kernels = TEST_KERNELS;
    return request;
}

profile_request test_usual_request(uint64_t n)
{
    static profile_pair pair;
    static profile_workload workload;
    pair = test_pair();
    workload = test_workload(n);
    return test_request(&pair, &workload);
}

double test_time(int device, uint64_t n, double share)
{
    double part = device == 0 ? share : 1 - share;
    double per_object = device == 0 ? 50 : 10;
    return part == 0 ? 0 : 50000 + 1.0 * (double)n + per_object * part * (double)n;
}

profile_trial test_trial(uint64_t n, double share, profile_sample *samples, uint32_t n_samples)
{
    double a = test_time(0, n, share);
    double b = test_time(1, n, share);
    double total = fmax(a, b);
    for (uint32_t i = 0; i < n_samples; ++i)
        samples[i] = (profile_sample){
            .total_ns = (int64_t)total + i,
            .a_ns = (int64_t)a,
            .b_ns = (int64_t)b,
            .transfer_ns = 100,
            .flags = i == 0 ? PROFILE_SAMPLE_WARM_UP : 0,
            .at_ns = 1763710000000000000 + i,
        };
    return (profile_trial){
        .plan = test_plan(share),
        .outcome = "ok",
        .build_ms = 12.5,
        .median_ns = total,
        .mad_ns = 1,
        .low_ns = total * 0.99,
        .high_ns = total * 1.01,
        .a_ns = a,
        .b_ns = b,
        .terms = "{\"T_CPU1\":1.5}",
        .scope = PROFILE_SHARE_ONE,
        .samples = samples,
        .n_samples = n_samples,
    };
}

void test_tune(store *s, const profile_pair *pair, const profile_workload *workload)
{
    int64_t pair_id = 0;
    int64_t workload_id = 0;
    must(profile_pair_put(s, pair, &pair_id, ERR));
    must(profile_workload_put(s, workload, &workload_id, ERR));
    profile_session session = test_session(pair_id, workload_id);
    char id[PROFILE_ID];
    must(profile_session_begin(s, &session, id, ERR));
    for (int i = 0; i <= 8; ++i) {
        profile_sample samples[4];
        profile_trial trial = test_trial(workload->n, i / 8.0, samples, 4);
        must(profile_trial_add(s, id, i, &trial, ERR));
    }
    profile_row row = {
        .pair_id = pair_id,
        .workload_id = workload_id,
        .kernels = TEST_KERNELS,
        .objective = "time",
        .plan = test_plan(1 / 8.0),
        .median_ns = fmax(test_time(0, workload->n, 1 / 8.0), test_time(1, workload->n, 1 / 8.0)),
        .gain = 0.12,
        .gain_low = 0.1,
        .gain_high = 0.14,
        .verdict = "faster",
        .origin = "measured",
        .session = id,
        .trial_number = 1,
    };
    row.low_ns = row.median_ns * 0.99;
    row.high_ns = row.median_ns * 1.01;
    must(profile_put(s, &row, NULL, "replaced by a later tuning", NULL, ERR));
    must(profile_session_end(s, id, "complete", ERR));
}

void test_tune_usual(store *s)
{
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
}

void test_store_tune(const char *path)
{
    store *s = test_store_open(path, STORE_WRITE);
    test_tune_usual(s);
    store_close(s);
}

void test_fill_out(store *s)
{
    profile_workload workload = test_workload(1000);
    workload.level = "auto";
    profile_level_cost_key key = {.pair_id = 1, .kernels = TEST_KERNELS};
    const profile_level_cost costs[] = {{"certified", 2e6, 70, 0, 0}, {"sat15", 1.9e6, 70, 3, 9}};
    must(profile_workload_put(s, &workload, &key.workload_id, ERR));
    must(profile_level_costs_put(s, &key, costs, 2, ERR));
    must(sql_script(s,
                    "UPDATE profile SET true_pairs = 70, single_ns = 3e6, best_share = 9, "
                    "best_mode = 'slab', terms = '{\"T_1\":1.5}', rounds = 20, whole_ns = 2e6, "
                    "whole_gain = 0.1, whole_gain_low = 0.05, whole_gain_high = 0.2",
                    ERR));
}

static void put_row(store *s, profile_row *row, const profile_workload *workload)
{
    must(profile_workload_put(s, workload, &row->workload_id, ERR));
    must(profile_put(s, row, NULL, "put again", NULL, ERR));
}

void test_store_plan(const char *path, const profile_pair *pair, const profile_workload *workload,
                     const char *kernels, const profile_plan *plan)
{
    store *s = test_store_open(path, STORE_WRITE);
    profile_row row = {
        .kernels = kernels,
        .objective = "time",
        .plan = *plan,
        .median_ns = 2e6,
        .low_ns = 1e6,
        .high_ns = 3e6,
        .gain = 0.5,
        .verdict = "faster",
        .origin = "manual",
        .trial_number = -1,
    };
    must(profile_pair_put(s, pair, &row.pair_id, ERR));
    put_row(s, &row, workload);
    store_close(s);
}

void test_fill(store *s, uint32_t n)
{
    profile_pair pair = test_pair();
    profile_row row = {
        .kernels = TEST_KERNELS,
        .objective = "time",
        .plan = test_plan(0),
        .verdict = "same",
        .origin = "manual",
        .trial_number = -1,
    };
    must(store_begin(s, ERR));
    must(profile_pair_put(s, &pair, &row.pair_id, ERR));
    for (uint32_t i = 0; i < n; ++i) {
        profile_workload workload = test_workload(1000 + i);
        row.plan.share = i;
        put_row(s, &row, &workload);
    }
    must(store_end(s, true, ERR));
}

int64_t test_count(store *s, const char *table)
{
    char query[256];
    int64_t n = 0;
    snprintf(query, sizeof query, "SELECT count(*) FROM %s", table);
    must(sql_number(s, query, &n, ERR));
    return n;
}
