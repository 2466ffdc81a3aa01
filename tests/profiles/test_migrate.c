// SPDX-License-Identifier: MIT
// A store of another version of Duet.
#include "support/test.h"

#include "profiles/sql.h"
#include "support/store.h"

TEST(a_store_of_another_version_is_refused_and_left_as_it_is)
{
    static const int versions[] = {1, STORE_FIRST_VERSION - 1, STORE_VERSION + 1, 99};
    test_folder folder = test_folder_make();
    store_close(test_store_open(folder.store, STORE_WRITE));
    for (size_t i = 0; i < sizeof versions / sizeof *versions; ++i) {
        char words[64];
        snprintf(words, sizeof words, "PRAGMA user_version = %d", versions[i]);
        test_store_run(folder.store, words);
        snprintf(words, sizeof words, "is of version %d, and this Duet knows", versions[i]);
        test_store_refuses(folder.store, STORE_READ, DUET_STATUS_STORE_FAILED, words);
        test_store_refuses(folder.store, STORE_WRITE, DUET_STATUS_STORE_FAILED, words);
    }
}

// One step, as a later version would bring it.
static const char *const upgrades[] = {
    "ALTER TABLE profile ADD COLUMN colour TEXT;"
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
    int64_t version = 0;
    must(sql_number(s, "PRAGMA user_version", &version, ERR));
    return version;
}

TEST(an_older_store_is_copied_and_upgraded)
{
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = test_store_open(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    must(migrate_upgrade(s, upgrades, ERR));
    assert_int_equal(version_of(s), STORE_FIRST_VERSION + 1);
    assert_int_equal(test_count(s, "profile WHERE colour IS NULL"), 1);
    assert_int_equal(test_count(s, "extra"), 1);
    char copy[128];
    snprintf(copy, sizeof copy, "%s.v%d", folder.store, STORE_FIRST_VERSION);
    assert_non_null(strstr(store_note(s), copy));
    store_close(s);
    s = test_store_open(copy, STORE_READ);
    assert_int_equal(test_count(s, "profile"), 1);
    assert_int_equal(test_count(s, "sqlite_schema WHERE name = 'extra'"), 0);
    store_close(s);
}

TEST(an_upgrade_that_fails_changes_nothing)
{
    store *s = test_store_fresh();
    must_fail(migrate_upgrade(s, broken_upgrades, ERR), DUET_STATUS_STORE_FAILED, "");
    assert_int_equal(version_of(s), STORE_FIRST_VERSION);
    assert_int_equal(test_count(s, "pragma_table_info('profile') WHERE name = 'colour'"), 0);
}

TEST_MAIN(NULL, NULL)
