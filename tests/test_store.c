// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "profiles/sql.h"
#include "runtime/base/rng.h"
#include "support/store.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static store *open_ok(const char *path, store_access access)
{
    duet_error err = {0};
    store *s = store_open(path, access, &err);
    assert_ok(s, err);
    return s;
}

// The line with which a store is refused.
static duet_error refusal(const char *path, store_access access)
{
    duet_error err = {0};
    assert_null(store_open(path, access, &err));
    assert_int_not_equal(err.status, DUET_OK);
    assert_non_null(strstr(err.text, path));
    assert_null(strchr(err.text, '\n'));
    return err;
}

static void write_bytes(const char *path, const char *bytes, size_t n)
{
    duet_error err = {0};
    assert_ok(text_write_file(path, bytes, n, &err), err);
}

static void assert_file_is(const char *path, const char *bytes, size_t n)
{
    text t = {0};
    duet_error err = {0};
    assert_ok(text_read_file(&t, path, &err), err);
    assert_int_equal(t.length, n);
    assert_memory_equal(t.chars, bytes, n);
    text_free(&t);
}

static void run_sql(const char *path, const char *statements)
{
    sqlite3 *db = NULL;
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, statements, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}

// ------------------------------------------------------------- making and opening

static void a_store_is_made_with_its_folders(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    char path[128];
    snprintf(path, sizeof path, "%s/a/b/profiles.db", folder.path);
    store *s = open_ok(path, STORE_WRITE);
    assert_true(store_writable(s));
    assert_null(store_note(s));
    assert_int_equal(test_count(s, "profile"), 0);
    store_close(s);
    store_close(open_ok(path, STORE_READ));
    test_folder_remove(&folder);
}

static void a_path_comes_from_the_environment(void **state)
{
    (void)state;
    text path = {0};
    duet_error err = {0};
    setenv("DUET_PROFILE", "/p/q.db", 1);
    setenv("XDG_DATA_HOME", "/x", 1);
    setenv("HOME", "/h", 1);
    assert_ok(store_user_path(&path, &err), err);
    assert_string_equal(text_chars(&path), "/p/q.db");
    text_free(&path);
    unsetenv("DUET_PROFILE");
    assert_ok(store_user_path(&path, &err), err);
    assert_string_equal(text_chars(&path), "/x/duet/profiles.db");
    text_free(&path);
    unsetenv("XDG_DATA_HOME");
    assert_ok(store_user_path(&path, &err), err);
    assert_string_equal(text_chars(&path), "/h/.local/share/duet/profiles.db");
    text_free(&path);
    unsetenv("HOME");
    assert_false(store_user_path(&path, &err));
    assert_int_equal(err.status, DUET_NOT_FOUND);
    text_free(&path);
}

static void the_system_store_is_the_first_that_exists(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    char path[128];
    snprintf(path, sizeof path, "%s/duet/profiles.db", folder.path);
    store_close(open_ok(path, STORE_WRITE));
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
    test_folder_remove(&folder);
}

static void a_missing_store_is_not_made_by_reading(void **state)
{
    (void)state;
    duet_error err = refusal("no/such/profiles.db", STORE_READ);
    assert_int_equal(err.status, DUET_NOT_FOUND);
    assert_int_not_equal(access("no", F_OK), 0);
}

static void an_empty_file_becomes_a_store_only_by_writing(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    write_bytes(folder.store, "", 0);
    assert_int_equal(refusal(folder.store, STORE_READ).status, DUET_NOT_FOUND);
    assert_file_is(folder.store, "", 0);
    store_close(open_ok(folder.store, STORE_WRITE));
    store_close(open_ok(folder.store, STORE_READ));
    test_folder_remove(&folder);
}

static void network_file_systems_keep_a_rollback_journal(void **state)
{
    (void)state;
    assert_string_equal(store_journal(0x6969), "delete");     // NFS
    assert_string_equal(store_journal(0xff534d42), "delete"); // CIFS
    assert_string_equal(store_journal((unsigned long)(int32_t)0xff534d42), "delete");
    assert_string_equal(store_journal(0xef53), "wal");     // ext4
    assert_string_equal(store_journal(0x01021994), "wal"); // tmpfs
}

// --------------------------------------------------------------- what is not ours

static void a_file_that_is_no_database_is_left_as_it_is(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    rng r = rng_seed(test_seed());
    for (size_t n = 1; n < 9000; n = n * 3 + 1) {
        char *bytes = malloc(n);
        assert_non_null(bytes);
        for (size_t i = 0; i < n; ++i)
            bytes[i] = (char)rng_below(&r, 256);
        write_bytes(folder.store, bytes, n);
        assert_non_null(strstr(refusal(folder.store, STORE_WRITE).text, "not a profile store"));
        assert_non_null(strstr(refusal(folder.store, STORE_READ).text, "not a profile store"));
        assert_file_is(folder.store, bytes, n);
        free(bytes);
    }
    test_folder_remove(&folder);
}

static void another_programs_database_is_left_as_it_is(void **state)
{
    (void)state;
    static const char *const others[] = {
        "CREATE TABLE t (x); INSERT INTO t VALUES (1)",
        "PRAGMA application_id = 252006675; CREATE TABLE t (x)",
        "PRAGMA user_version = 1; CREATE TABLE profile (x)",
    };
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        test_folder folder = test_folder_make();
        run_sql(folder.store, others[i]);
        text before = {0};
        duet_error err = {0};
        assert_ok(text_read_file(&before, folder.store, &err), err);
        assert_non_null(strstr(refusal(folder.store, STORE_WRITE).text, "another program's"));
        assert_non_null(strstr(refusal(folder.store, STORE_READ).text, "another program's"));
        assert_file_is(folder.store, before.chars, before.length);
        text_free(&before);
        test_folder_remove(&folder);
    }
}

static void a_folder_and_a_pipe_are_no_store(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    assert_non_null(strstr(refusal(folder.path, STORE_WRITE).text, "is a folder"));
    assert_int_equal(mkfifo(folder.store, 0600), 0);
    assert_non_null(strstr(refusal(folder.store, STORE_READ).text, "a device or a pipe"));
    test_folder_remove(&folder);
}

static void a_truncated_store_is_reported_and_kept(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_ok(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    text whole = {0};
    duet_error err = {0};
    assert_ok(text_read_file(&whole, folder.store, &err), err);
    for (size_t n = whole.length - 4096; n > 100; n /= 3) {
        write_bytes(folder.store, whole.chars, n);
        assert_non_null(strstr(refusal(folder.store, STORE_WRITE).text, "damaged"));
        assert_file_is(folder.store, whole.chars, n);
    }
    text_free(&whole);
    test_folder_remove(&folder);
}

// Wherever bytes are spoilt, every call ends, with rows or with one line.
static void a_damaged_store_never_crashes_a_look_up(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_ok(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    text whole = {0};
    duet_error err = {0};
    assert_ok(text_read_file(&whole, folder.store, &err), err);
    rng r = rng_seed(test_seed());
    profile_request request = test_request(&pair, &workload);
    int refused = 0;
    for (int round = 0; round < 200; ++round) {
        char *bytes = malloc(whole.length);
        assert_non_null(bytes);
        memcpy(bytes, whole.chars, whole.length);
        uint32_t from = 16 + rng_below(&r, (uint32_t)whole.length - 16);
        uint32_t length = 1 + rng_below(&r, 3000);
        for (size_t i = from; i < from + length && i < whole.length; ++i)
            bytes[i] = (char)rng_below(&r, 256);
        write_bytes(folder.store, bytes, whole.length);
        profile_found found;
        text why = {0};
        duet_error failure = {0};
        bool ok = profile_lookup_files(folder.store, NULL, &request, &found, &why, &failure);
        assert_true(ok || failure.text[0]);
        assert_true(ok || found.grade == PROFILE_DEFAULT);
        refused += !ok;
        assert_file_is(folder.store, bytes, whole.length);
        text_free(&why);
        free(bytes);
    }
    assert_true(refused > 0);
    text_free(&whole);
    test_folder_remove(&folder);
}

// ------------------------------------------------------------------------ versions

static void a_newer_store_is_read_and_not_written(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_ok(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    run_sql(folder.store, "PRAGMA user_version = 99");
    s = open_ok(folder.store, STORE_WRITE);
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

static void an_older_store_is_copied_and_upgraded(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_ok(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    assert_ok(migrate_upgrade(s, upgrades, &err), err);
    int64_t version = 0;
    assert_ok(sql_number(s, "PRAGMA user_version", &version, &err), err);
    assert_int_equal(version, 3);
    assert_int_equal(test_count(s, "profile WHERE colour IS NULL"), 1);
    assert_int_equal(test_count(s, "extra"), 1);
    char copy[128];
    snprintf(copy, sizeof copy, "%s.v1", folder.store);
    assert_non_null(strstr(store_note(s), copy));
    store_close(s);
    s = open_ok(copy, STORE_READ);
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
    store *s = open_ok(folder.store, STORE_WRITE);
    duet_error err = {0};
    assert_false(migrate_upgrade(s, broken_upgrades, &err));
    assert_int_equal(err.status, DUET_STORE_FAILED);
    int64_t version = 0;
    err = (duet_error){0};
    assert_ok(sql_number(s, "PRAGMA user_version", &version, &err), err);
    assert_int_equal(version, 1);
    assert_int_equal(test_count(s, "pragma_table_info('profile') WHERE name = 'colour'"), 0);
    store_close(s);
    test_folder_remove(&folder);
}

static void two_upgrades_keep_two_copies(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
    duet_error err = {0};
    assert_ok(migrate_upgrade(s, upgrades, &err), err);
    store_close(s);
    run_sql(folder.store, "ALTER TABLE profile DROP COLUMN colour; DROP TABLE extra; "
                          "PRAGMA user_version = 1");
    s = open_ok(folder.store, STORE_WRITE);
    assert_ok(migrate_upgrade(s, upgrades, &err), err);
    assert_non_null(strstr(store_note(s), ".v1.1"));
    store_close(s);
    test_folder_remove(&folder);
}

// -------------------------------------------------------------- what cannot be written

// Runs `what` in a process of its own: as a user without rights, or under a
// limit that must not outlive it.
static void in_a_process(void (*what)(const test_folder *), const test_folder *folder)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        what(folder);
        _exit(0);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

static void expect(bool fact, const char *what, const duet_error *err)
{
    if (fact)
        return;
    fprintf(stderr, "not so: %s (%s)\n", what, err->text);
    _exit(1);
}

static void write_without_rights(const test_folder *folder)
{
    duet_error err = {0};
    if (geteuid() == 0 && setuid(65534) != 0)
        _exit(1);
    store *s = store_open(folder->store, STORE_WRITE, &err);
    expect(!s && strstr(err.text, "cannot be written"), "a read-only file is named", &err);
    err = (duet_error){0};
    s = store_open(folder->store, STORE_READ, &err);
    expect(s, "a read-only file is read", &err);
    store_close(s);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    profile_request request = test_request(&pair, &workload);
    profile_found found;
    expect(profile_lookup_files(folder->store, NULL, &request, &found, NULL, &err) &&
               found.grade == PROFILE_EXACT,
           "a read-only file is looked up in", &err);
}

static void a_read_only_store_is_looked_up_in_and_not_tuned_into(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_ok(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    usleep(100000); // until the file counts as settled
    chmod(folder.store, 0444);
    chmod(folder.path, 0555);
    in_a_process(write_without_rights, &folder);
    chmod(folder.path, 0755);
    test_folder_remove(&folder);
}

static void make_without_rights(const test_folder *folder)
{
    duet_error err = {0};
    if (geteuid() == 0 && setuid(65534) != 0)
        _exit(1);
    char path[128];
    snprintf(path, sizeof path, "%s/deeper/profiles.db", folder->path);
    expect(!store_open(path, STORE_WRITE, &err) && strstr(err.text, "cannot be made"),
           "a folder that cannot be made is named", &err);
    err = (duet_error){0};
    expect(!store_open(folder->store, STORE_WRITE, &err) && strstr(err.text, folder->store),
           "a file that cannot be made is named", &err);
}

static void reading_leaves_no_file_behind(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store_close(open_ok(folder.store, STORE_WRITE));
    store *s = open_ok(folder.store, STORE_READ);
    assert_int_equal(test_count(s, "profile"), 0);
    duet_error err = {0};
    assert_false(sql_script(s, "DELETE FROM profile", &err));
    store_close(s);
    char side[128];
    snprintf(side, sizeof side, "%s-shm", folder.store);
    assert_int_not_equal(access(side, F_OK), 0);
    test_folder_remove(&folder);
}

static void a_read_only_folder_is_named(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    chmod(folder.path, 0555);
    in_a_process(make_without_rights, &folder);
    chmod(folder.path, 0755);
    test_folder_remove(&folder);
}

static void tune_until_full(const test_folder *folder)
{
    signal(SIGXFSZ, SIG_IGN);
    struct stat info;
    stat(folder->store, &info);
    struct rlimit limit = {(rlim_t)info.st_size + 200000, (rlim_t)info.st_size + 200000};
    setrlimit(RLIMIT_FSIZE, &limit);
    duet_error err = {0};
    store *s = store_open(folder->store, STORE_WRITE, &err);
    expect(s, "it opens", &err);
    char id[PROFILE_ID];
    profile_session session = test_session(1, 1);
    expect(profile_session_begin(s, &session, id, &err), "a session begins", &err);
    bool ok = true;
    for (int i = 0; ok && i < 1000; ++i) {
        profile_sample samples[64];
        profile_trial trial = test_trial(1000, 0.25, samples, 64);
        int64_t number = 0;
        ok = profile_trial_add(s, id, &trial, NULL, &number, &err);
        expect(!ok || number == i, "trials are numbered", &err);
    }
    expect(!ok && strstr(err.text, "disk is full"), "a full disk is named", &err);
    store_close(s);
}

static void a_full_disk_loses_only_what_did_not_fit(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = open_ok(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    in_a_process(tune_until_full, &folder);
    s = open_ok(folder.store, STORE_WRITE);
    assert_int_equal(test_count(s, "profile"), 1);
    assert_true(test_count(s, "trial") > 9);
    assert_int_equal(test_count(s, "trial t WHERE launches <> (SELECT count(*) FROM sample "
                                   "WHERE trial_id = t.id AND flags & 1 = 0)"),
                     0);
    assert_int_equal(test_count(s, "pragma_integrity_check WHERE integrity_check <> 'ok'"), 0);
    store_close(s);
    test_folder_remove(&folder);
}

// ----------------------------------------------------------------------- transactions

static void a_failure_inside_undoes_the_whole_transaction(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
    duet_error err = {0};
    assert_ok(store_begin(s, &err), err);
    assert_ok(store_audit(s, "outer", "", &err), err);
    assert_ok(store_begin(s, &err), err);
    assert_ok(store_audit(s, "inner", "", &err), err);
    assert_false(store_end(s, false, &err));
    assert_false(store_end(s, true, &err));
    assert_int_equal(test_count(s, "audit"), 0);
    store_close(s);
    test_folder_remove(&folder);
}

// ------------------------------------------------------------------------- rows

static void a_pair_and_a_workload_are_stored_once(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
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
        assert_int_equal(err.status, DUET_BAD_ARGUMENT);
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
    store *s = open_ok(folder.store, STORE_WRITE);
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
    assert_string_equal(t.last.plan.variant_b, "rows sort=radix");
    assert_true(t.last.a_ns == test_time(0, 1000, 0.5));
    assert_int_equal(t.last_total, (int64_t)test_time(0, 1000, 0.5) + 3);
    store_close(s);
    test_folder_remove(&folder);
}

static void a_trial_without_measurements_needs_a_reason_and_no_times(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
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
    store *s = open_ok(folder.store, STORE_WRITE);
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

// ----------------------------------------------------------------------- sessions

static void a_stopped_session_is_resumed_with_its_state(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    profile_session session = test_session(1, 1);
    profile_resumed resumed;
    assert_ok(profile_session_resume(s, &session, &resumed, &err), err);
    assert_int_equal(resumed.claim, PROFILE_CLAIM_NONE); // the tuned one is complete
    profile_resumed_free(&resumed);
    char id[PROFILE_ID];
    assert_ok(profile_session_begin(s, &session, id, &err), err);
    profile_sample samples[2];
    profile_trial trial = test_trial(1000, 0.5, samples, 2);
    int64_t number = 0;
    assert_ok(profile_trial_add(s, id, &trial, "{\"low\":0.25}", &number, &err), err);
    assert_ok(profile_session_resume(s, &session, &resumed, &err), err);
    assert_int_equal(resumed.claim, PROFILE_CLAIM_BUSY); // this process lives
    assert_int_equal(resumed.pid, getpid());
    profile_resumed_free(&resumed);
    assert_ok(profile_session_end(s, id, "stopped", &err), err);
    assert_ok(profile_session_resume(s, &session, &resumed, &err), err);
    assert_int_equal(resumed.claim, PROFILE_CLAIM_RESUMED);
    assert_string_equal(resumed.id, id);
    assert_string_equal(text_chars(&resumed.search_state), "{\"low\":0.25}");
    assert_int_equal(resumed.trials, 1);
    profile_resumed_free(&resumed);
    store_close(s);
    test_folder_remove(&folder);
}

static void another_search_is_not_resumed(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    profile_session session = test_session(1, 1);
    char id[PROFILE_ID];
    assert_ok(profile_session_begin(s, &session, id, &err), err);
    assert_ok(profile_session_end(s, id, "stopped", &err), err);
    profile_session others[5] = {session, session, session, session, session};
    others[0].strategy = "golden";
    others[1].kernels = "changed";
    others[2].seed = 2;
    others[3].options = "{\"launches\":17}";
    others[4].objective = "energy";
    for (int i = 0; i < 5; ++i) {
        profile_resumed resumed;
        assert_ok(profile_session_resume(s, &others[i], &resumed, &err), err);
        assert_int_equal(resumed.claim, PROFILE_CLAIM_NONE);
        profile_resumed_free(&resumed);
    }
    store_close(s);
    test_folder_remove(&folder);
}

static void a_dead_owners_session_is_resumed(void **state)
{
    (void)state;
    static const char *const owners[] = {
        "UPDATE session SET pid_start = pid_start + 1",            // the number went to another
        "UPDATE session SET pid = 999999999",                      // no such process
        "UPDATE session SET host = 'elsewhere', heartbeat_ns = 1", // long silent
    };
    for (size_t i = 0; i < sizeof owners / sizeof owners[0]; ++i) {
        test_folder folder = test_folder_make();
        store *s = open_ok(folder.store, STORE_WRITE);
        profile_pair pair = test_pair();
        profile_workload workload = test_workload(1000);
        test_tune(s, &pair, &workload);
        duet_error err = {0};
        profile_session session = test_session(1, 1);
        char id[PROFILE_ID];
        assert_ok(profile_session_begin(s, &session, id, &err), err);
        assert_ok(sql_script(s, owners[i], &err), err);
        profile_resumed resumed;
        assert_ok(profile_session_resume(s, &session, &resumed, &err), err);
        assert_int_equal(resumed.claim, PROFILE_CLAIM_RESUMED);
        assert_string_equal(resumed.id, id);
        profile_resumed_free(&resumed);
        store_close(s);
        test_folder_remove(&folder);
    }
}

static void a_silent_owner_elsewhere_is_given_ten_minutes(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    duet_error err = {0};
    profile_session session = test_session(1, 1);
    char id[PROFILE_ID];
    assert_ok(profile_session_begin(s, &session, id, &err), err);
    assert_ok(sql_script(s, "UPDATE session SET host = 'elsewhere', pid = 999999999", &err), err);
    profile_resumed resumed;
    assert_ok(profile_session_resume(s, &session, &resumed, &err), err);
    assert_int_equal(resumed.claim, PROFILE_CLAIM_BUSY);
    profile_resumed_free(&resumed);
    store_close(s);
    test_folder_remove(&folder);
}

static void what_is_not_json_is_refused(void **state)
{
    (void)state;
    test_folder folder = test_folder_make();
    store *s = open_ok(folder.store, STORE_WRITE);
    static const char *const bad[] = {"", "[1]", "{\"a\":}", "{} trailing", "{\"a\":1"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        duet_error err = {0};
        profile_session session = test_session(1, 1);
        char id[PROFILE_ID];
        session.options = bad[i];
        assert_false(profile_session_begin(s, &session, id, &err));
        assert_int_equal(err.status, DUET_BAD_ARGUMENT);
    }
    store_close(s);
    test_folder_remove(&folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_store_is_made_with_its_folders),
        cmocka_unit_test(a_path_comes_from_the_environment),
        cmocka_unit_test(the_system_store_is_the_first_that_exists),
        cmocka_unit_test(a_missing_store_is_not_made_by_reading),
        cmocka_unit_test(an_empty_file_becomes_a_store_only_by_writing),
        cmocka_unit_test(network_file_systems_keep_a_rollback_journal),
        cmocka_unit_test(a_file_that_is_no_database_is_left_as_it_is),
        cmocka_unit_test(another_programs_database_is_left_as_it_is),
        cmocka_unit_test(a_folder_and_a_pipe_are_no_store),
        cmocka_unit_test(a_truncated_store_is_reported_and_kept),
        cmocka_unit_test(a_damaged_store_never_crashes_a_look_up),
        cmocka_unit_test(a_newer_store_is_read_and_not_written),
        cmocka_unit_test(an_older_store_is_copied_and_upgraded),
        cmocka_unit_test(each_version_but_the_last_has_an_upgrade),
        cmocka_unit_test(an_upgrade_that_fails_changes_nothing),
        cmocka_unit_test(two_upgrades_keep_two_copies),
        cmocka_unit_test(a_read_only_store_is_looked_up_in_and_not_tuned_into),
        cmocka_unit_test(reading_leaves_no_file_behind),
        cmocka_unit_test(a_read_only_folder_is_named),
        cmocka_unit_test(a_full_disk_loses_only_what_did_not_fit),
        cmocka_unit_test(a_failure_inside_undoes_the_whole_transaction),
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
        cmocka_unit_test(a_stopped_session_is_resumed_with_its_state),
        cmocka_unit_test(another_search_is_not_resumed),
        cmocka_unit_test(a_dead_owners_session_is_resumed),
        cmocka_unit_test(a_silent_owner_elsewhere_is_given_ten_minutes),
        cmocka_unit_test(what_is_not_json_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
