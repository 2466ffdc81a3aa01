// SPDX-License-Identifier: MIT
// A store of an older or a newer Duet.
#include "support/test.h"

#include "base/text_file.h"
#include "profiles/profile.h"
#include "profiles/sql.h"
#include "profiles/upkeep.h"
#include "support/store.h"
#include "tuner/trial_log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ------------------------------------------------------------------------ versions

static void a_newer_store_is_read_and_not_written(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = test_store_open(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    test_store_run(folder.store, "PRAGMA user_version = 99");
    s = test_store_open(folder.store, STORE_WRITE);
    assert_false(store_writable(s));
    assert_non_null(strstr(store_note(s), "newer Duet (version 99"));
    assert_int_equal(test_count(s, "profile"), 1);
    duet_error err = {0};
    assert_false(profile_session_end(s, "x", "failed", &err));
    assert_non_null(strstr(err.text, "reading only"));
    store_close(s);
    test_folder_remove(&folder);
}

// Upgrades as a later version would bring them.
static const char *const upgrades[] = {
    "ALTER TABLE profile ADD COLUMN colour TEXT",
    "CREATE TABLE extra (id INTEGER PRIMARY KEY) STRICT; INSERT INTO extra VALUES (7)",
    NULL,
};

static const char *const broken_upgrades[] = {
    "ALTER TABLE profile ADD COLUMN colour TEXT",
    "INSERT INTO no_such_table VALUES (1)",
    NULL,
};

static int64_t version_of(store *s)
{
    duet_error err = {0};
    int64_t version = 0;
    assert_ok(sql_number(s, "PRAGMA user_version", &version, &err), err);
    return version;
}

// One that a Duet wrote which knew the first version only.
static store *open_first_version(const test_folder *folder)
{
    store *s = test_store_open(folder->store, STORE_WRITE);
    duet_error err = {0};
    assert_ok(sql_script(s, "PRAGMA user_version = 1", &err), err);
    return s;
}

static void an_older_store_is_copied_and_upgraded(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_first_version(&folder);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    assert_ok(migrate_upgrade(s, upgrades, &err), err);
    assert_int_equal(version_of(s), 3); // two upgrades on
    assert_int_equal(test_count(s, "profile WHERE colour IS NULL"), 1);
    assert_int_equal(test_count(s, "extra"), 1);
    char copy[128];
    snprintf(copy, sizeof copy, "%s.v1", folder.store);
    assert_non_null(strstr(store_note(s), copy));
    store_close(s);
    assert_non_null(strstr(test_store_refusal(copy, STORE_READ).text, "of the older version 1"));
    char pragma[64];
    snprintf(pragma, sizeof pragma, "PRAGMA user_version = %d", STORE_VERSION);
    test_store_run(copy, pragma);
    s = test_store_open(copy, STORE_READ);
    assert_int_equal(test_count(s, "profile"), 1);
    assert_int_equal(test_count(s, "sqlite_schema WHERE name = 'extra'"), 0);
    store_close(s);
    test_folder_remove(&folder);
}

static void each_version_but_the_last_has_an_upgrade(void **state)
{
    (void)state;
    int n = 0;
    while (migrate_upgrades[n])
        ++n;
    assert_int_equal(n + 1, STORE_VERSION);
}

static void an_upgrade_that_fails_changes_nothing(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_first_version(&folder);
    duet_error err = {0};
    assert_false(migrate_upgrade(s, broken_upgrades, &err));
    assert_int_equal(err.status, DUET_STATUS_STORE_FAILED);
    assert_int_equal(version_of(s), 1);
    assert_int_equal(test_count(s, "pragma_table_info('profile') WHERE name = 'colour'"), 0);
    store_close(s);
    test_folder_remove(&folder);
}

static void two_upgrades_keep_two_copies(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_first_version(&folder);
    duet_error err = {0};
    assert_ok(migrate_upgrade(s, upgrades, &err), err);
    assert_ok(sql_script(s,
                         "ALTER TABLE profile DROP COLUMN colour; DROP TABLE extra; "
                         "PRAGMA user_version = 1",
                         &err),
              err);
    assert_ok(migrate_upgrade(s, upgrades, &err), err);
    assert_non_null(strstr(store_note(s), ".v1.1"));
    store_close(s);
    test_folder_remove(&folder);
}

// ------------------------------------------------------------------ what was upgraded

// A file as an older version made it, with a tuned workload in it.
static store *upgrade_from(int version, const test_folder *folder)
{
    text script = {0};
    duet_error err = {0};
    char path[512];
    snprintf(path, sizeof path, "%s/store_v%d.sql", getenv("DUET_TEST_DATA"), version);
    assert_ok(text_read_file(&script, path, &err), err);
    test_store_run(folder->store, text_chars(&script));
    text_free(&script);
    store *s = test_store_open(folder->store, STORE_WRITE);
    assert_int_equal(version_of(s), STORE_VERSION);
    return s;
}

static void tell_columns(store *s, text *columns)
{
    duet_error err = {0};
    sql q = sql_make(s,
                     "SELECT t.name || '.' || c.name || ' ' || c.type || ' ' || c.\"notnull\" "
                     "FROM sqlite_schema t JOIN pragma_table_info(t.name) c "
                     "WHERE t.type = 'table' ORDER BY 1",
                     &err);
    while (sql_row(&q))
        text_add(columns, "%s\n", sql_get_text(&q, 0));
    assert_ok(sql_close(&q), err);
}

static void an_upgraded_store_has_the_columns_of_a_fresh_one(void **state)
{
    (void)state;
    test_folder fresh_folder = test_folder_make();
    store *fresh = test_store_open(fresh_folder.store, STORE_WRITE);
    text expected = {0};
    tell_columns(fresh, &expected);
    assert_non_null(strstr(text_chars(&expected), "level_cost.missed INTEGER 1"));
    for (int version = 1; version < STORE_VERSION; ++version) {
        test_folder folder = test_folder_make();
        store *s = upgrade_from(version, &folder);
        text columns = {0};
        tell_columns(s, &columns);
        assert_string_equal(text_chars(&columns), text_chars(&expected));
        text_free(&columns);
        store_close(s);
        test_folder_remove(&folder);
    }
    text_free(&expected);
    store_close(fresh);
    test_folder_remove(&fresh_folder);
}

static void what_the_second_version_stored_is_kept_under_its_new_names(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = upgrade_from(2, &folder);
    assert_int_equal(test_count(s, "level_cost"), 6);
    assert_int_equal(test_count(s, "profile WHERE variant_a = 'auto' AND variant_b = 'simd'"), 1);
    assert_int_equal(test_count(s, "trial WHERE variant_a GLOB 'rows*' OR variant_b = 'lanes'"), 0);
    assert_int_equal(test_count(s, "fit WHERE variant IN ('auto', 'simd')"), 4);
    sql q = sql_make(s, "SELECT search_state FROM session", &(duet_error){0});
    assert_true(sql_row(&q));
    trial_log log = {0};
    duet_error err = {0};
    assert_ok(trial_log_from_json(&log, sql_get_text(&q, 0), &err), err);
    assert_int_equal(log.n, test_count(s, "trial"));
    trial_log_free(&log);
    sql_close(&q);
    store_close(s);
    test_folder_remove(&folder);
}

// The third version loaded plans that no race had spoken for.
static void a_plan_without_a_verdict_of_the_third_version_is_not_used(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = upgrade_from(3, &folder);
    assert_int_equal(test_count(s, "profile WHERE verdict = 'ambiguous' AND live = 0 AND "
                                   "dead_reason = '" PROFILE_UNFOUNDED "'"),
                     1);
    assert_int_equal(test_count(s, "profile WHERE verdict = 'faster' AND live = 1 AND "
                                   "rounds IS NULL AND whole_ns IS NULL"),
                     1);
    store_close(s);
    test_folder_remove(&folder);
}

// Their keys leave out what only queries have.
static void what_the_fourth_version_stored_keeps_its_keys(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = upgrade_from(4, &folder);
    text report = {0};
    duet_error err = {0};
    uint32_t problems = 1;
    assert_ok(profile_check(s, &report, &problems, &err), err);
    assert_string_equal(report.chars ? report.chars : "", "");
    assert_int_equal(problems, 0);
    assert_int_equal(test_count(s, "workload WHERE query IS NULL AND boxes = 0"),
                     test_count(s, "workload"));
    text_free(&report);
    store_close(s);
    test_folder_remove(&folder);
}

static void what_the_fifth_version_stored_is_sound(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = upgrade_from(5, &folder);
    text report = {0};
    duet_error err = {0};
    uint32_t problems = 1;
    assert_ok(profile_check(s, &report, &problems, &err), err);
    assert_int_equal(problems, 0);
    assert_int_equal(test_count(s, "workload WHERE query = 'rays closest' AND n = 2000"), 1);
    assert_int_equal(test_count(s, "profile"), 3);
    text_free(&report);
    store_close(s);
    test_folder_remove(&folder);
}

// The first version kept no count of wrong pairs: only certified has none by
// itself.
static void what_the_first_version_stored_serves_no_accuracy_but_certified(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = upgrade_from(1, &folder);
    profile_pair pair = test_pair();
    static const char *const levels[] = {"certified", "sat6"};
    for (int i = 0; i < 2; ++i) {
        profile_workload workload = test_workload(1000);
        workload.level = levels[i];
        profile_request request = test_request(&pair, &workload);
        profile_found found;
        duet_error err = {0};
        assert_ok(profile_lookup(s, &request, &found, NULL, &err), err);
        assert_int_equal(found.grade, PROFILE_EXACT);
        assert_int_equal(found.true_pairs, -1);
        request.levels = &levels[i];
        request.n_levels = 1;
        request.max_missed_rate = 0;
        request.max_false_rate = 0.5;
        assert_ok(profile_lookup(s, &request, &found, NULL, &err), err);
        assert_int_equal(found.grade, i == 0 ? PROFILE_EXACT : PROFILE_DEFAULT);
    }
    store_close(s);
    test_folder_remove(&folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_newer_store_is_read_and_not_written),
        cmocka_unit_test(an_older_store_is_copied_and_upgraded),
        cmocka_unit_test(each_version_but_the_last_has_an_upgrade),
        cmocka_unit_test(an_upgrade_that_fails_changes_nothing),
        cmocka_unit_test(two_upgrades_keep_two_copies),
        cmocka_unit_test(an_upgraded_store_has_the_columns_of_a_fresh_one),
        cmocka_unit_test(what_the_second_version_stored_is_kept_under_its_new_names),
        cmocka_unit_test(a_plan_without_a_verdict_of_the_third_version_is_not_used),
        cmocka_unit_test(what_the_fourth_version_stored_keeps_its_keys),
        cmocka_unit_test(what_the_fifth_version_stored_is_sound),
        cmocka_unit_test(what_the_first_version_stored_serves_no_accuracy_but_certified),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
