// SPDX-License-Identifier: MIT
// What a store keeps: devices, workloads, trials, profiles.
#include "support/test.h"

#include "profiles/sql.h"
#include "support/store.h"

#include <string.h>

// ------------------------------------------------------------------------- rows

static void a_pair_and_a_workload_are_stored_once(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    duet_error err = {0};
    profile_pair pair = test_pair();
    profile_pair swapped = {pair.b, pair.a};
    profile_workload workload = test_workload(1000);
    int64_t ids[6] = {0};
    assert_ok(profile_pair_put(s, &pair, &ids[0], &err), err);
    assert_ok(profile_pair_put(s, &pair, &ids[1], &err), err);
    assert_ok(profile_pair_put(s, &swapped, &ids[2], &err), err);
    assert_ok(profile_workload_put(s, &workload, &ids[3], &err), err);
    assert_ok(profile_workload_put(s, &workload, &ids[4], &err), err);
    assert_int_equal(ids[0], ids[1]);
    assert_int_not_equal(ids[0], ids[2]);
    assert_int_equal(ids[3], ids[4]);
    assert_int_equal(test_count(s, "device"), 2);
    assert_int_equal(test_count(s, "env"), 2);
    store_close(s);
    test_folder_remove(&folder);
}

static void every_field_of_a_device_tells_devices_apart(void **state)
{
    (void)state;
    profile_env env = test_pair().b;
    profile_env others[12];
    for (int i = 0; i < 12; ++i)
        others[i] = env;
    // Two names that differ only past the fiftieth character.
    env.device.name = "A device whose name is longer than fifty characters, model X";
    others[0].device.name = "A device whose name is longer than fifty characters, model Y";
    others[1].device.vendor = "another";
    others[2].device.kind = "accel";
    others[3].device.units = 1;
    others[4].device.max_group = 1;
    others[5].device.local_bytes = 1;
    others[6].device.global_bytes = 1;
    others[7].platform = "another";
    others[8].driver = "another";
    others[9].part = "0-1";
    others[10].part_units = 2;
    others[11].limits = "power 200 W";
    char keys[13][PROFILE_SHA];
    profile_env_key(&env, keys[12]);
    for (int i = 0; i < 12; ++i) {
        profile_env_key(&others[i], keys[i]);
        for (int j = 0; j < i; ++j)
            assert_string_not_equal(keys[i], keys[j]);
        assert_string_not_equal(keys[i], keys[12]);
    }
}

static void a_drivers_version_changes_the_key_and_not_the_seat(void **state)
{
    (void)state;
    profile_env env = test_pair().b;
    profile_env newer = env;
    newer.driver = "560.1";
    char keys[4][PROFILE_SHA];
    profile_env_key(&env, keys[0]);
    profile_env_key(&newer, keys[1]);
    profile_env_seat(&env, keys[2]);
    profile_env_seat(&newer, keys[3]);
    assert_string_not_equal(keys[0], keys[1]);
    assert_string_equal(keys[2], keys[3]);
}

static void a_hosts_memory_does_not_change_its_cpu(void **state)
{
    (void)state;
    profile_device cpu = test_pair().a.device;
    char keys[2][PROFILE_SHA];
    profile_device_key(&cpu, keys[0]);
    cpu.global_bytes /= 2;
    profile_device_key(&cpu, keys[1]);
    assert_string_equal(keys[0], keys[1]);
}

static void two_draws_of_one_scene_are_one_workload(void **state)
{
    (void)state;
    profile_workload w = test_workload(1000000);
    profile_workload other = w;
    other.occ_mean *= 1.001;
    other.cells[0] += 1;
    other.name = "mine";
    char keys[2][PROFILE_SHA];
    duet_error err = {0};
    assert_ok(profile_workload_key(&w, keys[0], &err), err);
    assert_ok(profile_workload_key(&other, keys[1], &err), err);
    assert_string_equal(keys[0], keys[1]);
}

static void the_order_of_effects_does_not_matter_and_the_effects_do(void **state)
{
    (void)state;
    static const char *const effects[] = {"gravity motion", " motion  gravity motion", "motion"};
    char keys[3][PROFILE_SHA];
    duet_error err = {0};
    for (int i = 0; i < 3; ++i) {
        profile_workload w = test_workload(1000);
        w.effects = effects[i];
        assert_ok(profile_workload_key(&w, keys[i], &err), err);
    }
    assert_string_equal(keys[0], keys[1]);
    assert_string_not_equal(keys[0], keys[2]);
}

static void a_workload_that_cannot_be_is_refused(void **state)
{
    (void)state;
    profile_workload bad[4] = {test_workload(1), test_workload(1), test_workload(1),
                               test_workload(1)};
    bad[0].dims = 4;
    bad[1].n = 0;
    bad[2].size_ratio = 0.5;
    bad[3].occ_mean = 0.0 / 0.0;
    for (int i = 0; i < 4; ++i) {
        char key[PROFILE_SHA];
        duet_error err = {0};
        assert_false(profile_workload_key(&bad[i], key, &err));
        assert_int_equal(err.status, DUET_STATUS_BAD_ARGUMENT);
    }
}

typedef struct tally {
    int trials;
    int launches;
    profile_trial last;
    int64_t last_total;
} tally;

static bool count_trial(void *context, int64_t number, const profile_trial *trial)
{
    tally *t = context;
    assert_int_equal(number, t->trials);
    ++t->trials;
    t->launches += (int)trial->n_samples;
    t->last = *trial;
    t->last_total = trial->samples[trial->n_samples - 1].total_ns;
    return t->trials < 5;
}

static void a_trial_comes_back_as_it_went_in(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    sql q = sql_make(s, "SELECT id FROM session", &err);
    assert_true(sql_row(&q));
    tally t = {0};
    assert_ok(profile_trial_each(s, sql_get_text(&q, 0), count_trial, &t, &err), err);
    assert_ok(sql_close(&q), err);
    assert_int_equal(t.trials, 5); // stopped when the visitor said so
    assert_int_equal(t.launches, 20);
    assert_int_equal(t.last.plan.share, 32768);
    assert_string_equal(t.last.plan.mode, "own");
    assert_string_equal(t.last.plan.variant_b, "auto sort=radix");
    assert_true(t.last.a_ns == test_time(0, 1000, 0.5));
    assert_int_equal(t.last_total, (int64_t)test_time(0, 1000, 0.5) + 3);
    store_close(s);
    test_folder_remove(&folder);
}

static void a_trial_without_measurements_needs_a_reason_and_no_times(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    profile_session session = test_session(1, 1);
    char id[PROFILE_ID];
    assert_ok(profile_session_begin(s, &session, id, &err), err);
    profile_trial trial = {.plan = test_plan(0.5), .outcome = "build", .reason = "no local memory"};
    int64_t number = -1;
    assert_ok(profile_trial_add(s, id, &trial, NULL, &number, &err), err);
    assert_int_equal(number, 0);
    assert_int_equal(test_count(s, "trial WHERE outcome = 'build' AND median_ns IS NULL"), 1);
    trial.outcome = "ok";
    assert_false(profile_trial_add(s, id, &trial, NULL, &number, &err));
    assert_int_equal(test_count(s, "trial WHERE session_id <> ''"), 10);
    store_close(s);
    test_folder_remove(&folder);
}

static void a_replaced_profile_stays_dead_with_its_reason(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    test_tune(s, &pair, &workload);
    assert_int_equal(test_count(s, "profile"), 2);
    assert_int_equal(test_count(s, "profile WHERE live = 1"), 1);
    assert_int_equal(test_count(s, "profile WHERE dead_reason = 'tuned again'"), 1);
    store_close(s);
    test_folder_remove(&folder);
}
static void what_is_not_json_is_refused(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    static const char *const bad[] = {"", "[1]", "{\"a\":}", "{} trailing", "{\"a\":1"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        duet_error err = {0};
        profile_session session = test_session(1, 1);
        char id[PROFILE_ID];
        session.options = bad[i];
        assert_false(profile_session_begin(s, &session, id, &err));
        assert_int_equal(err.status, DUET_STATUS_BAD_ARGUMENT);
    }
    store_close(s);
    test_folder_remove(&folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pair_and_a_workload_are_stored_once),
        cmocka_unit_test(every_field_of_a_device_tells_devices_apart),
        cmocka_unit_test(a_drivers_version_changes_the_key_and_not_the_seat),
        cmocka_unit_test(a_hosts_memory_does_not_change_its_cpu),
        cmocka_unit_test(two_draws_of_one_scene_are_one_workload),
        cmocka_unit_test(the_order_of_effects_does_not_matter_and_the_effects_do),
        cmocka_unit_test(a_workload_that_cannot_be_is_refused),
        cmocka_unit_test(a_trial_comes_back_as_it_went_in),
        cmocka_unit_test(a_trial_without_measurements_needs_a_reason_and_no_times),
        cmocka_unit_test(a_replaced_profile_stays_dead_with_its_reason),
        cmocka_unit_test(what_is_not_json_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
