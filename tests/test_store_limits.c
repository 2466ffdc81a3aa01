// SPDX-License-Identifier: MIT
// A store where nothing can be written: no rights, no room.
#define _GNU_SOURCE
#include "support/test.h"

#include "profiles/sql.h"
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
    store *s = test_store_open(folder.store, STORE_WRITE);
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
    store_close(test_store_open(folder.store, STORE_WRITE));
    store *s = test_store_open(folder.store, STORE_READ);
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
    store *s = test_store_open(folder.store, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    in_a_process(tune_until_full, &folder);
    s = test_store_open(folder.store, STORE_WRITE);
    assert_int_equal(test_count(s, "profile"), 1);
    assert_true(test_count(s, "trial") > 9);
    assert_int_equal(test_count(s, "trial t WHERE launches <> (SELECT count(*) FROM sample "
                                   "WHERE trial_id = t.id AND flags & 1 = 0)"),
                     0);
    assert_int_equal(test_count(s, "pragma_integrity_check WHERE integrity_check <> 'ok'"), 0);
    store_close(s);
    test_folder_remove(&folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_read_only_store_is_looked_up_in_and_not_tuned_into),
        cmocka_unit_test(reading_leaves_no_file_behind),
        cmocka_unit_test(a_read_only_folder_is_named),
        cmocka_unit_test(a_full_disk_loses_only_what_did_not_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
