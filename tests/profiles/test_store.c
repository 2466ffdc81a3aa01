// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "base/text_file.h"
#include "profiles/exchange.h"
#include "profiles/sql.h"
#include "support/store.h"

#include <unistd.h>

static void write_bytes(const char *path, const char *bytes, size_t n)
{
    must(text_write_file(path, bytes, n, ERR));
}

static void assert_file_is(const char *path, const char *bytes, size_t n)
{
    const text t = test_read_file(path);
    assert_int_equal(t.length, n);
    assert_memory_equal(t.chars, bytes, n);
}

// ------------------------------------------------------------- making and opening

TEST(a_store_is_made_with_its_folders)
{
    test_folder folder = test_folder_make();
    char path[128];
    snprintf(path, sizeof path, "%s/a/b/profiles.db", folder.path);
    store *s = test_store_open(path, STORE_WRITE);
    assert_true(store_writable(s));
    assert_null(store_note(s));
    assert_int_equal(test_count(s, "profile"), 0);
    store_close(s);
    store_close(test_store_open(path, STORE_READ));
}

TEST(a_path_comes_from_the_environment)
{
    text path = {0};
    setenv("DUET_PROFILE", "/p/q.db", 1);
    setenv("XDG_DATA_HOME", "/x", 1);
    setenv("HOME", "/h", 1);
    must(store_user_path(&path, ERR));
    assert_string_equal(text_chars(&path), "/p/q.db");
    text_free(&path);
    unsetenv("DUET_PROFILE");
    must(store_user_path(&path, ERR));
    assert_string_equal(text_chars(&path), "/x/duet/profiles.db");
    text_free(&path);
    unsetenv("XDG_DATA_HOME");
    must(store_user_path(&path, ERR));
    assert_string_equal(text_chars(&path), "/h/.local/share/duet/profiles.db");
    text_free(&path);
    unsetenv("HOME");
    must_fail(store_user_path(&path, ERR), DUET_STATUS_NOT_FOUND, "");
    text_free(&path);
}

TEST(the_system_store_is_the_first_that_exists)
{
    test_folder folder = test_folder_make();
    char path[128];
    snprintf(path, sizeof path, "%s/duet/profiles.db", folder.path);
    store_close(test_store_open(path, STORE_WRITE));
    char dirs[160];
    snprintf(dirs, sizeof dirs, "/nowhere:%s:/nowhere", folder.path);
    setenv("XDG_DATA_DIRS", dirs, 1);
    text found = {0};
    assert_true(store_system_path(&found));
    assert_string_equal(text_chars(&found), path);
    text_free(&found);
    setenv("XDG_DATA_DIRS", "/nowhere", 1);
    assert_false(store_system_path(&found));
    unsetenv("XDG_DATA_DIRS");
}

TEST(a_missing_store_is_not_made_by_reading)
{
    test_store_refuses("no/such/profiles.db", STORE_READ, DUET_STATUS_NOT_FOUND, "");
    assert_int_not_equal(access("no", F_OK), 0);
}

TEST(an_empty_file_becomes_a_store_only_by_writing)
{
    test_folder folder = test_folder_make();
    write_bytes(folder.store, "", 0);
    test_store_refuses(folder.store, STORE_READ, DUET_STATUS_NOT_FOUND, "");
    assert_file_is(folder.store, "", 0);
    store_close(test_store_open(folder.store, STORE_WRITE));
    store_close(test_store_open(folder.store, STORE_READ));
}

TEST(network_file_systems_keep_a_rollback_journal)
{
    assert_string_equal(store_journal(0x6969), "delete");     // NFS
    assert_string_equal(store_journal(0xff534d42), "delete"); // CIFS
    assert_string_equal(store_journal((unsigned long)(int32_t)0xff534d42), "delete");
    assert_string_equal(store_journal(0xef53), "wal");     // ext4
    assert_string_equal(store_journal(0x01021994), "wal"); // tmpfs
}

// ------------------------------------------------------------------------- paths

// Names that mean something else to SQLite, to URIs or to a shell.
static const char *const odd_names[] = {
    ":memory:",
    "file:x.db",
    "file:x.db?mode=memory",
    "file::memory:?cache=shared",
    "a?mode=ro.db",
    "50%41.db",
    "#.db",
    "a b.db",
    "it's \"it\".db",
    "new\nline.db",
    "\xff\xfe\x80.db",
    "\\.db",
    "-.db",
    "x;y$(z).db",
    "%00.db",
    "\xc3\xa9.db",
};

static void assert_is_a_store(const char *path)
{
    char head[16] = "";
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("there is no file '%s'", path);
    size_t n = fread(head, 1, sizeof head, file);
    fclose(file);
    assert_int_equal(n, sizeof head);
    assert_memory_equal(head, "SQLite format 3", 16);
}

static void take_a_store_through(const char *path)
{
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    profile_request request = test_request(&pair, &workload);
    profile_found found;
    store *s = test_store_open(path, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    assert_is_a_store(path);
    s = test_store_open(path, STORE_READ); // waits until it rests
    assert_int_equal(test_count(s, "profile"), 1);
    store_close(s);
    must(profile_lookup_files(path, NULL, &request, &found, NULL, ERR));
    assert_int_equal(found.grade, PROFILE_EXACT);
    s = test_store_open("other.db", STORE_WRITE);
    profile_import_counts counts;
    must(profile_merge(s, path, &counts, ERR));
    assert_true(counts.added > 0);
    store_close(s);
    remove("other.db");
}

// One file with exactly that name, in the folder one is in and by its whole path.
TEST(a_path_names_that_very_file)
{
    char whole[256];
    test_folder folder = test_folder_make();
    assert_int_equal(chdir(folder.path), 0);
    for (size_t i = 0; i < sizeof odd_names / sizeof odd_names[0]; ++i) {
        take_a_store_through(odd_names[i]);
        assert_int_equal(test_count_files(), 1);
        assert_int_equal(remove(odd_names[i]), 0);
        snprintf(whole, sizeof whole, "/%s/%s", folder.path, odd_names[i]);
        take_a_store_through(whole);
        assert_int_equal(test_count_files(), 1);
        assert_int_equal(remove(odd_names[i]), 0);
    }
}

TEST(a_folder_called_file_leads_nowhere_else)
{
    char whole[128];
    test_folder folder = test_folder_make();
    store_close(test_store_open(folder.store, STORE_WRITE));
    snprintf(whole, sizeof whole, "file:%s", folder.store);
    test_store_refuses(whole, STORE_READ, DUET_STATUS_NOT_FOUND, "");
}

TEST(an_empty_path_is_refused)
{
    test_store_refuses("", STORE_WRITE, DUET_STATUS_STORE_FAILED, "path is empty");
    test_store_refuses("", STORE_READ, DUET_STATUS_STORE_FAILED, "path is empty");
}

// --------------------------------------------------------------- what is not ours

TEST(a_file_that_is_no_database_is_left_as_it_is)
{
    test_folder folder = test_folder_make();
    rng r = rng_seed(test_seed());
    for (size_t n = 1; n < 9000; n = n * 3 + 1) {
        char *bytes = test_alloc(n);
        for (size_t i = 0; i < n; ++i)
            bytes[i] = (char)rng_below(&r, 256);
        write_bytes(folder.store, bytes, n);
        test_store_refuses(folder.store, STORE_WRITE, DUET_STATUS_STORE_FAILED,
                           "not a profile store");
        test_store_refuses(folder.store, STORE_READ, DUET_STATUS_STORE_FAILED,
                           "not a profile store");
        assert_file_is(folder.store, bytes, n);
    }
}

TEST(another_programs_database_is_left_as_it_is)
{
    static const char *const others[] = {
        "CREATE TABLE t (x); INSERT INTO t VALUES (1)",
        "PRAGMA application_id = 252006675; CREATE TABLE t (x)",
        "PRAGMA user_version = 1; CREATE TABLE profile (x)",
    };
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        test_folder folder = test_folder_make();
        test_store_run(folder.store, others[i]);
        const text before = test_read_file(folder.store);
        test_store_refuses(folder.store, STORE_WRITE, DUET_STATUS_STORE_FAILED,
                           "another program's");
        test_store_refuses(folder.store, STORE_READ, DUET_STATUS_STORE_FAILED, "another program's");
        assert_file_is(folder.store, before.chars, before.length);
    }
}

TEST(a_folder_and_a_pipe_are_no_store)
{
    test_folder folder = test_folder_make();
    test_store_refuses(folder.path, STORE_WRITE, DUET_STATUS_STORE_FAILED, "is a folder");
    assert_int_equal(mkfifo(folder.store, 0600), 0);
    test_store_refuses(folder.store, STORE_READ, DUET_STATUS_STORE_FAILED, "a device or a pipe");
}

TEST(a_truncated_store_is_reported_and_kept)
{
    test_folder folder = test_folder_make();
    test_store_tune(folder.store);
    const text whole = test_read_file(folder.store);
    for (size_t n = whole.length - 4096; n > 100; n /= 3) {
        write_bytes(folder.store, whole.chars, n);
        test_store_refuses(folder.store, STORE_WRITE, DUET_STATUS_STORE_FAILED, "damaged");
        assert_file_is(folder.store, whole.chars, n);
    }
}

// Wherever bytes are spoilt, every call ends, with rows or with one line.
TEST(a_damaged_store_never_crashes_a_look_up)
{
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = test_store_open(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    const text whole = test_read_file(folder.store);
    rng r = rng_seed(test_seed());
    profile_request request = test_request(&pair, &workload);
    int refused = 0;
    for (int round = 0; round < 200; ++round) {
        char *bytes = test_alloc(whole.length);
        memcpy(bytes, whole.chars, whole.length);
        uint32_t from = 16 + rng_below(&r, (uint32_t)whole.length - 16);
        uint32_t length = 1 + rng_below(&r, 3000);
        for (size_t i = from; i < from + length && i < whole.length; ++i)
            bytes[i] = (char)rng_below(&r, 256);
        write_bytes(folder.store, bytes, whole.length);
        profile_found found;
        own(text) why = {0};
        duet_error failure = {0};
        bool ok = profile_lookup_files(folder.store, NULL, &request, &found, &why, &failure);
        assert_int_equal(failure.status, ok ? DUET_STATUS_OK : DUET_STATUS_STORE_FAILED);
        if (!ok) {
            assert_says(failure.text, folder.store);
            assert_int_equal(found.grade, PROFILE_DEFAULT);
        }
        refused += !ok;
        assert_file_is(folder.store, bytes, whole.length);
    }
    assert_true(refused > 0);
}

// Whatever such a file says to be is run when a table of that name is read.
TEST(a_view_or_trigger_of_a_stranger_is_refused)
{
    static const refusal cases[] = {
        {"ALTER TABLE profile RENAME TO old; CREATE VIEW profile AS SELECT old.* FROM old, (WITH "
         "RECURSIVE r(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM r) SELECT x FROM r) WHERE x < 0",
         "holds a view 'profile' that Duet does not make"},
        {"DROP VIEW part; CREATE VIEW part AS SELECT 1", "view 'part'"},
        {"CREATE TRIGGER t AFTER INSERT ON audit BEGIN DELETE FROM profile; END", "trigger 't'"},
        {"CREATE VIRTUAL TABLE v USING fts5(x)", "table 'v'"},
    };
    static const store_access accesses[] = {STORE_READ, STORE_WRITE};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        test_folder folder = test_folder_make();
        store *s = test_store_open(folder.store, STORE_WRITE);
        must(sql_script(s, cases[i].given, ERR));
        store_close(s);
        for (int k = 0; k < 2; ++k)
            must_fail(store_open(folder.store, accesses[k], ERR), DUET_STATUS_STORE_FAILED,
                      cases[i].says);
    }
}

// ----------------------------------------------------------------------- transactions

TEST(a_failure_inside_undoes_the_whole_transaction)
{
    store *s = test_store_fresh();
    must(store_begin(s, ERR));
    must(store_audit(s, "outer", "", ERR));
    must(store_begin(s, ERR));
    must(store_audit(s, "inner", "", ERR));
    must_fail(store_end(s, false, ERR), DUET_STATUS_OK, "");
    must_fail(store_end(s, true, ERR), DUET_STATUS_OK, "");
    assert_int_equal(test_count(s, "audit"), 0);
}

// ---------------------------------------------------------------- stores of other versions

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
    store *s = test_store_open(folder.store, STORE_WRITE);
    test_tune_usual(s);
    must(migrate_upgrade(s, upgrades, ERR));
    assert_int_equal(version_of(s), STORE_FIRST_VERSION + 1);
    assert_int_equal(test_count(s, "profile WHERE colour IS NULL"), 1);
    assert_int_equal(test_count(s, "extra"), 1);
    char copy[128];
    snprintf(copy, sizeof copy, "%s.v%d", folder.store, STORE_FIRST_VERSION);
    assert_says(store_note(s), copy);
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
