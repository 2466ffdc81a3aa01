// SPDX-License-Identifier: MIT
// A store where nothing can be written: no rights, no space.
#define _GNU_SOURCE
#include "support/test.h"

#include "profiles/duet_profiles.h"
#include "profiles/exchange.h"
#include "profiles/sql.h"
#include "profiles/upkeep.h"
#include "support/store.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

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
    profile_request request = test_usual_request(1000);
    profile_found found;
    expect(profile_lookup_files(folder->store, NULL, &request, &found, NULL, &err) &&
               found.grade == PROFILE_EXACT,
           "a read-only file is looked up in", &err);
}

TEST(a_read_only_store_is_looked_up_in_and_not_tuned_into)
{
    test_folder folder = test_folder_make();
    test_store_tune(folder.store);
    usleep(100000); // until the file counts as settled
    chmod(folder.store, 0444);
    chmod(folder.path, 0555);
    in_a_process(write_without_rights, &folder);
    chmod(folder.path, 0755);
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

TEST(reading_leaves_no_file_behind)
{
    test_folder folder = test_folder_make();
    store_close(test_store_open(folder.store, STORE_WRITE));
    store *s = test_store_open(folder.store, STORE_READ);
    assert_int_equal(test_count(s, "profile"), 0);
    must_fail(sql_script(s, "DELETE FROM profile", ERR), DUET_STATUS_STORE_FAILED, "");
    store_close(s);
    char side[128];
    snprintf(side, sizeof side, "%s-shm", folder.store);
    assert_int_not_equal(access(side, F_OK), 0);
}

TEST(a_read_only_folder_is_named)
{
    test_folder folder = test_folder_make();
    chmod(folder.path, 0555);
    in_a_process(make_without_rights, &folder);
    chmod(folder.path, 0755);
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
        ok = profile_trial_add(s, id, i, &trial, &err);
    }
    expect(!ok && strstr(err.text, "disk is full"), "a full disk is named", &err);
    store_close(s);
}

TEST(a_full_disk_loses_only_what_did_not_fit)
{
    test_folder folder = test_folder_make();
    test_store_tune(folder.store);
    in_a_process(tune_until_full, &folder);
    store *s = test_store_open(folder.store, STORE_WRITE);
    assert_int_equal(test_count(s, "profile"), 1);
    assert_true(test_count(s, "trial") > 9);
    assert_int_equal(test_count(s, "trial t WHERE launches <> (SELECT count(*) FROM sample "
                                   "WHERE trial_id = t.id AND flags & 1 = 0)"),
                     0);
    assert_int_equal(test_count(s, "pragma_integrity_check WHERE integrity_check <> 'ok'"), 0);
    store_close(s);
}

// ------------------------------------------------------------------ what fails at once

static void make_under_a_limit(const test_folder *folder)
{
    signal(SIGXFSZ, SIG_IGN);
    for (rlim_t bytes = 0; bytes < 60000; bytes += 1777) {
        struct rlimit limit = {bytes, RLIM_INFINITY};
        setrlimit(RLIMIT_FSIZE, &limit);
        duet_error err = {0};
        store *s = store_open(folder->store, STORE_WRITE, &err);
        expect(!s && strstr(err.text, folder->store) && strstr(err.text, "disk is full"),
               "a store that does not fit is refused", &err);
        expect(rmdir(folder->path) == 0 && mkdir(folder->path, 0755) == 0,
               "nothing of it is left in the folder", &err);
    }
}

TEST(a_store_that_does_not_fit_leaves_nothing)
{
    test_folder folder = test_folder_make();
    in_a_process(make_under_a_limit, &folder);
    store_close(test_store_open(folder.store, STORE_WRITE));
}

// Every means by which a store is read, on one that is not to be written.
static void read_by_all_means(const test_folder *folder)
{
    duet_error err = {0};
    profile_request request = test_usual_request(1000);
    profile_found found;
    expect(profile_lookup_files(folder->store, NULL, &request, &found, NULL, &err) &&
               found.grade == PROFILE_EXACT,
           "it is looked up in", &err);
    store *s = store_open(folder->store, STORE_READ, &err);
    expect(s, "it opens", &err);
    int64_t n = 0;
    expect(sql_number(s, "SELECT count(*) FROM profile", &n, &err) && n == 1, "it is read", &err);
    own(text) report = {0};
    uint32_t problems = 0;
    expect(profile_check(s, &report, &problems, &err) && problems == 0, "it is checked", &err);
    expect(store_check_read(s, &err), "what was read counts", &err);
    store_close(s);
    duet_profile_list *list = duet_profile_list_create(folder->store, true, &err);
    expect(duet_profile_list_get_count(list) == 1, "it is listed", &err);
    duet_profile_list_destroy(list);
}

static void tune_one(const char *path)
{
    test_store_tune(path);
}

static void fill_up(const char *path)
{
    static const char zeros[4096];
    int file = open(path, O_WRONLY | O_CREAT, 0600);
    size_t n = sizeof zeros;
    while (n > 0)
        if (write(file, zeros, n) <= 0)
            n /= 2;
    close(file);
}

// A file system of one megabyte, in a name space of this process alone.
static bool mount_small(const char *path)
{
    bool mounted = geteuid() == 0 && unshare(CLONE_NEWNS) == 0 &&
                   mount(NULL, "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0 &&
                   mount("tmpfs", path, "tmpfs", 0, "size=1m") == 0;
    if (!mounted)
        fprintf(stderr, "no file system can be mounted here: skipped\n");
    return mounted;
}

static void read_on_a_full_disk(const test_folder *folder)
{
    if (!mount_small(folder->path))
        return;
    char filler[96];
    snprintf(filler, sizeof filler, "%s/filler", folder->path);
    tune_one(folder->store);
    fill_up(filler);
    read_by_all_means(folder);
    duet_error err = {0};
    char other[96];
    snprintf(other, sizeof other, "%s/other.db", folder->path);
    expect(!store_open(other, STORE_WRITE, &err) && strstr(err.text, "disk is full"),
           "another store does not fit", &err);
    expect(access(other, F_OK) != 0, "and is not there", &err);
    expect(!profile_export_file(store_open(folder->store, STORE_READ, NULL), profile_export, other,
                                &err),
           "an export does not fit", &err);
    expect(access(other, F_OK) != 0, "and is not there either", &err);
}

TEST(a_full_disk_is_read)
{
    test_folder folder = test_folder_make();
    in_a_process(read_on_a_full_disk, &folder);
}

static void read_as_another(const test_folder *folder)
{
    if (geteuid() == 0 && setuid(65534) != 0)
        _exit(1);
    read_by_all_means(folder);
}

// Not its owner, and in no way able to write: neither the file nor beside it.
TEST(a_store_of_another_user_is_read)
{
    test_folder folder = test_folder_make();
    tune_one(folder.store);
    chmod(folder.path, 0555);
    usleep(100000); // until the file counts as settled
    in_a_process(read_as_another, &folder);
    chmod(folder.path, 0755);
}

// Ends without closing: the rows are in the side file only.
static void write_and_die(const test_folder *folder)
{
    duet_error err = {0};
    store *s = store_open(folder->store, STORE_WRITE, &err);
    expect(s && store_begin(s, &err) && store_audit(s, "killed", "after this", &err) &&
               store_end(s, true, &err),
           "it writes", &err);
    _exit(0);
}

static int64_t count_killed(const test_folder *folder, duet_error *err)
{
    int64_t n = -1;
    store *s = store_open(folder->store, STORE_READ, err);
    if (s && !sql_number(s, "SELECT count(*) FROM audit WHERE what = 'killed'", &n, err))
        n = -1;
    store_close(s);
    return n;
}

static void read_what_was_left_as_another(const test_folder *folder)
{
    duet_error err = {0};
    char side[128];
    if (geteuid() == 0 && setuid(65534) != 0)
        _exit(1);
    expect(count_killed(folder, &err) == 1, "the side file is read", &err);
    snprintf(side, sizeof side, "%s-wal", folder->store);
    expect(access(side, F_OK) == 0, "and stays", &err);
}

static void be_refused_what_was_left(const test_folder *folder)
{
    duet_error err = {0};
    if (geteuid() == 0 && setuid(65534) != 0)
        _exit(1);
    expect(count_killed(folder, &err) < 0 && strstr(err.text, "let its owner open it once"),
           "what cannot be read whole is refused", &err);
}

// Whoever may not write reads them too, or is told who must open it first; the
// owner puts them into the file.
TEST(rows_of_a_killed_writer_are_read_or_their_owner_is_named)
{
    test_folder folder = test_folder_make();
    char side[128];
    snprintf(side, sizeof side, "%s-shm", folder.store);
    tune_one(folder.store);
    in_a_process(write_and_die, &folder);
    chmod(folder.path, 0555);
    in_a_process(read_what_was_left_as_another, &folder);
    chmod(folder.path, 0755);
    assert_int_equal(remove(side), 0); // the memory that readers share
    chmod(folder.path, 0555);
    in_a_process(be_refused_what_was_left, &folder);
    chmod(folder.path, 0755);
    duet_error err = {0};
    assert_int_equal(count_killed(&folder, &err), 1);
    assert_int_not_equal(access(side, F_OK), 0);
}

// A text that anybody may have put there is not held in memory to be shown.
TEST(a_text_that_is_too_long_is_told_of_with_its_row)
{
    static const char *const texts[][2] = {
        {"device SET name = %s WHERE id = 1", "row 1 of table device is longer than 16 MiB"},
        {"profile SET verdict = 'same', kernels = %s", "row 1 of table profile is longer"},
        {"session SET options = '{' || %s || '}'", "row 1 of table session is longer"},
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        test_folder folder = test_folder_make();
        tune_one(folder.store);
        char change[160] = "UPDATE ";
        snprintf(change + strlen(change), sizeof change - strlen(change), texts[i][0],
                 "printf('%.*c', 20000000, 'x')");
        sqlite3 *db = NULL;
        assert_int_equal(sqlite3_open(folder.store, &db), SQLITE_OK);
        assert_int_equal(sqlite3_exec(db, change, NULL, NULL, NULL), SQLITE_OK);
        sqlite3_close(db);
        store *s = must(store_open(folder.store, STORE_READ, ERR));
        FILE *nowhere = tmpfile();
        must_fail(profile_export(s, nowhere, "x", ERR), DUET_STATUS_STORE_FAILED, texts[i][1]);
        fclose(nowhere);
        store_close(s);
    }
}
