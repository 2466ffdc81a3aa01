// SPDX-License-Identifier: MIT
// Runs of clusters in a store, and the networks between their ranks.
#include "support/test.h"

#include "profiles/cluster_run.h"
#include "profiles/sql.h"
#include "support/store.h"

#include <stdio.h>
#include <string.h>

enum { RANKS = 3 };

static profile_fabric some_fabric(void)
{
    return (profile_fabric){.mpi = "Some MPI 1.0",
                            .place = TEST_KERNELS,
                            .hosts = 2,
                            .ranks = RANKS,
                            .latency_ns = 1500,
                            .byte_ns = 0.125,
                            .times = "{\"8\": 1500}"};
}

static profile_cluster_run some_run(void)
{
    return (profile_cluster_run){.scene = "grains",
                                 .dims = 2,
                                 .n = 0x100000001,
                                 .level = "certified",
                                 .parts = 4,
                                 .resident = true,
                                 .steps = 5,
                                 .median_ns = 2e6,
                                 .low_ns = 1e6,
                                 .high_ns = 3e6};
}

static const profile_cluster_rank rows[RANKS] = {{"a:0,b:0", 40, 3, 9, 120, 3e6, 1e6},
                                                 {"a:1,b:1", 37, 4, 8, 160, 2e6, 2e6},
                                                 {"a:2,b:2", 0, 0, 0, 0, 1e6, 3e6}};

static bool tell_uid(void *context, const cluster_run_entry *e)
{
    snprintf(context, PROFILE_ID, "%s", e->uid);
    assert_string_equal(e->run.scene, "grains");
    assert_int_equal(e->run.n, 0x100000001);
    assert_true(e->run.resident && e->run.parts == 4 && e->run.dims == 2 && e->run.steps == 5);
    assert_true(e->run.median_ns == 2e6 && e->run.low_ns == 1e6 && e->run.high_ns == 3e6);
    assert_true(e->efficiency == 0.5);
    assert_int_equal(e->fabric.ranks, RANKS);
    return true;
}

static bool compare_rank(void *context, uint32_t number, const profile_cluster_rank *row)
{
    assert_int_equal(number, (*(uint32_t *)context)++);
    assert_string_equal(row->devices, rows[number].devices);
    assert_true(row->n == rows[number].n && row->ghosts == rows[number].ghosts);
    assert_true(row->pairs == rows[number].pairs && row->sent_bytes == rows[number].sent_bytes);
    assert_true(row->busy_ns == rows[number].busy_ns && row->wait_ns == rows[number].wait_ns);
    return true;
}

static void a_run_is_kept_with_its_ranks(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    duet_error err = {0};
    profile_fabric fabric = some_fabric();
    profile_cluster_run run = some_run();
    char uid[PROFILE_ID], listed[PROFILE_ID] = "", whole[PROFILE_ID];
    assert_ok(cluster_run_put(s, &fabric, &run, rows, uid, &err), err);
    assert_ok(cluster_run_each(s, NULL, tell_uid, listed, &err), err);
    assert_string_equal(listed, uid);
    uint32_t n = 0;
    assert_ok(cluster_rank_each(s, 1, compare_rank, &n, &err), err);
    assert_int_equal(n, RANKS);

    uid[8] = '\0';
    assert_ok(cluster_run_find(s, uid, whole, &err), err);
    assert_string_equal(whole, listed);
    assert_ok(cluster_run_find(s, "none", whole, &err), err);
    assert_string_equal(whole, "");
    assert_ok(cluster_run_forget(s, listed, &err), err);
    assert_int_equal(test_count(s, "cluster_run") + test_count(s, "cluster_rank"), 0);
    assert_int_equal(test_count(s, "fabric"), 1);
    store_close(s);
    test_folder_remove(&folder);
}

// The same ranks on the same machines are one fabric, as it was last measured.
static void a_fabric_is_what_was_measured_last(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    duet_error err = {0};
    profile_fabric fabric = some_fabric();
    profile_cluster_run run = some_run();
    char uid[PROFILE_ID], whole[PROFILE_ID];
    assert_ok(cluster_run_put(s, &fabric, &run, rows, uid, &err), err);
    fabric.latency_ns = 900;
    fabric.times = "{\"8\": 900}";
    assert_ok(cluster_run_put(s, &fabric, &run, rows, uid, &err), err);
    assert_int_equal(test_count(s, "fabric WHERE latency_ns = 900 AND times = '{\"8\": 900}'"), 1);
    assert_int_equal(test_count(s, "fabric"), 1);
    assert_false(cluster_run_find(s, "", whole, &err));
    assert_non_null(strstr(err.text, "2 runs of clusters begin with ''; give more digits"));
    err = (duet_error){0};
    fabric.mpi = "Some MPI 2.0";
    assert_ok(cluster_run_put(s, &fabric, &run, rows, uid, &err), err);
    assert_int_equal(test_count(s, "fabric"), 2);
    store_close(s);
    test_folder_remove(&folder);
}

static void a_run_that_cannot_be_leaves_nothing(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    char uid[PROFILE_ID];
    for (int i = 0; i < 3; ++i) {
        duet_error err = {0};
        profile_fabric fabric = some_fabric();
        profile_cluster_run run = some_run();
        profile_cluster_rank bad[RANKS] = {rows[0], rows[1], rows[2]};
        if (i == 0)
            fabric.times = "{} , {}";
        if (i == 1)
            run.low_ns = 9e9;
        if (i == 2)
            bad[2].busy_ns = -1;
        assert_false(cluster_run_put(s, &fabric, &run, bad, uid, &err));
        assert_int_equal(test_count(s, "fabric") + test_count(s, "cluster_run"), 0);
    }
    store_close(s);
    test_folder_remove(&folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_is_kept_with_its_ranks),
        cmocka_unit_test(a_fabric_is_what_was_measured_last),
        cmocka_unit_test(a_run_that_cannot_be_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
