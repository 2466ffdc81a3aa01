// SPDX-License-Identifier: MIT
// Several processes on one store, some of them killed.
#define _GNU_SOURCE
#include "support/test.h"

#include "profiles/sql.h"
#include "profiles/upkeep.h"
#include "support/store.h"

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

enum { WRITERS = 8, READERS = 8, TRIALS = 25, SAMPLES = 5, KILLS = 40 };

// In a child a failed fact ends the process: cmocka belongs to the parent.
static void require(bool fact, const char *what, const duet_error *err)
{
    if (fact)
        return;
    fprintf(stderr, "not so: %s: %s\n", what, err->text);
    _exit(1);
}

static pid_t start(void (*work)(const char *path, int who), const char *path, int who)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        work(path, who);
        _exit(0);
    }
    return child;
}

static void assert_all_ended_well(const pid_t *children, int n)
{
    int failed = 0;
    for (int i = 0; i < n; ++i) {
        int status = 0;
        assert_int_equal(waitpid(children[i], &status, 0), children[i]);
        failed += !WIFEXITED(status) || WEXITSTATUS(status) != 0;
    }
    assert_int_equal(failed, 0);
}

static void assert_sound(store *s)
{
    own(text) report = {0};
    uint32_t problems = 0;
    must(profile_check(s, &report, &problems, ERR));
    if (problems)
        fail_msg("%s", text_chars(&report));
    assert_int_equal(
        test_count(s, "trial t WHERE (SELECT count(*) FROM sample WHERE trial_id = t.id) <> 5"), 0);
}

static void begin(store *s, uint64_t n, profile_session *session, char id[PROFILE_ID])
{
    duet_error err = {0};
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(n);
    int64_t pair_id = 0;
    int64_t workload_id = 0;
    require(profile_pair_put(s, &pair, &pair_id, &err), "the pair is put", &err);
    require(profile_workload_put(s, &workload, &workload_id, &err), "the workload is put", &err);
    *session = test_session(pair_id, workload_id);
    require(profile_session_begin(s, session, id, &err), "the session begins", &err);
}

static void add_trial(store *s, const char *id, int i)
{
    duet_error err = {0};
    profile_sample samples[SAMPLES];
    profile_trial trial = test_trial(100000, (i % 9) / 8.0, samples, SAMPLES);
    require(profile_trial_add(s, id, i, &trial, &err), "a trial is added", &err);
}

static void put_profile(store *s, const profile_session *session, const char *id)
{
    duet_error err = {0};
    profile_row row = {
        .pair_id = session->pair_id,
        .workload_id = session->workload_id,
        .kernels = TEST_KERNELS,
        .objective = "time",
        .plan = test_plan(0.125),
        .median_ns = 2,
        .low_ns = 1,
        .high_ns = 3,
        .verdict = "faster",
        .origin = "measured",
        .session = id,
        .trial_number = 1,
    };
    require(profile_put(s, &row, NULL, "replaced by a later tuning", NULL, &err),
            "the profile is put", &err);
    require(profile_session_end(s, id, "complete", &err), "the session ends", &err);
}

// Half of the writers share a workload. Each opens the store twice.
static void write_rows(const char *path, int who)
{
    duet_error err = {0};
    store *s = store_open(path, STORE_WRITE, &err);
    require(s, "a writer opens", &err);
    char id[PROFILE_ID];
    profile_session session;
    begin(s, who % 2 ? 1000 : 2000 + (uint64_t)who, &session, id);
    for (int i = 0; i < TRIALS / 2; ++i)
        add_trial(s, id, i);
    store_close(s);
    s = store_open(path, STORE_WRITE, &err);
    require(s, "a writer opens again", &err);
    for (int i = TRIALS / 2; i < TRIALS; ++i)
        add_trial(s, id, i);
    put_profile(s, &session, id);
    store_close(s);
}

// Looks up until the workload that four writers share has its profile, or the test's time is over.
// Each row that is seen is whole; on a machine that is busy enough a look-up may give up waiting.
static void read_rows(const char *path, int who)
{
    (void)who;
    profile_request request = test_usual_request(1000);
    for (;;) {
        profile_found found;
        duet_error err = {0};
        require(profile_lookup_files(path, NULL, &request, &found, NULL, &err) ||
                    (found.grade == PROFILE_DEFAULT && strstr(err.text, "keeps it locked")),
                "a look-up ends well", &err);
        if (found.grade == PROFILE_EXACT) {
            require(found.plan.share == 8192 && found.median_ns == 2, "the row is whole", &err);
            return;
        }
        usleep(10000);
    }
}

TEST(writers_and_readers_do_not_disturb_each_other)
{
    test_folder folder = test_folder_make(); // the first writer makes the file
    pid_t children[WRITERS + READERS];
    for (int i = 0; i < WRITERS; ++i)
        children[i] = start(write_rows, folder.store, i);
    for (int i = 0; i < READERS; ++i)
        children[WRITERS + i] = start(read_rows, folder.store, i);
    assert_all_ended_well(children, WRITERS + READERS);
    store *s = kept(store_open(folder.store, STORE_WRITE, ERR));
    assert_int_equal(test_count(s, "session WHERE state = 'complete'"), WRITERS);
    assert_int_equal(test_count(s, "trial"), WRITERS * TRIALS);
    assert_int_equal(test_count(s, "profile"), WRITERS);
    assert_int_equal(test_count(s, "profile WHERE live = 1"), 1 + WRITERS / 2);
    assert_int_equal(test_count(s, "pair"), 1);
    assert_sound(s);
}

// Exactly one of many processes that want a session gets it. They live until all have asked.
enum { CLAIMANTS = 6 };
static int claim_pipe[2], end_pipe[2];

static void claim(const char *path, int who)
{
    (void)who;
    duet_error err = {0};
    store *s = store_open(path, STORE_WRITE, &err);
    require(s, "it opens", &err);
    profile_session session = test_session(1, 1);
    profile_resumed resumed;
    require(profile_session_resume(s, &session, &resumed, &err), "a claim ends well", &err);
    char said = (char)('0' + (int)resumed.claim);
    require(write(claim_pipe[1], &said, 1) == 1, "it is told", &err);
    close(end_pipe[1]);
    require(read(end_pipe[0], &said, 1) == 0, "all have asked", &err);
    store_close(s);
}

TEST(one_of_many_takes_up_a_stopped_session)
{
    test_folder folder = test_folder_make();
    store *s = must(store_open(folder.store, STORE_WRITE, ERR));
    char id[PROFILE_ID];
    profile_session session;
    begin(s, 1000, &session, id);
    must(profile_session_end(s, id, "stopped", ERR));
    store_close(s);
    assert_int_equal(pipe(claim_pipe), 0);
    assert_int_equal(pipe(end_pipe), 0);
    pid_t children[CLAIMANTS];
    for (int i = 0; i < CLAIMANTS; ++i)
        children[i] = start(claim, folder.store, i);
    close(claim_pipe[1]); // a child that fails closes its own, so none is waited for in vain
    char said;
    int resumed = 0, asked = 0;
    for (; asked < CLAIMANTS && read(claim_pipe[0], &said, 1) == 1; ++asked)
        resumed += said == '0' + PROFILE_CLAIM_RESUMED;
    close(end_pipe[1]);
    assert_all_ended_well(children, CLAIMANTS);
    assert_int_equal(asked, CLAIMANTS);
    assert_int_equal(resumed, 1);
    close(claim_pipe[0]);
    close(end_pipe[0]);
}

static int told_pipe[2];

// Tells the number of trials after each that is stored, until it is killed.
static void write_until_killed(const char *path, int who)
{
    (void)who;
    duet_error err = {0};
    store *s = store_open(path, STORE_WRITE, &err);
    require(s, "a writer opens", &err);
    char id[PROFILE_ID];
    profile_session session;
    begin(s, 1000, &session, id);
    for (int i = 0;; ++i) {
        add_trial(s, id, i);
        int32_t stored = i + 1;
        require(write(told_pipe[1], &stored, sizeof stored) == sizeof stored, "it is told", &err);
    }
}

static int32_t last_told(void)
{
    int32_t told = 0;
    int32_t last = 0;
    while (read(told_pipe[0], &told, sizeof told) == sizeof told)
        last = told;
    close(told_pipe[0]);
    return last;
}

// Every fourth writer is killed early, the others somewhere after their first trial.
static void await_death(int round, rng *r)
{
    struct pollfd told = {.fd = told_pipe[0], .events = POLLIN};
    close(told_pipe[1]);
    if (round % 4 != 0)
        assert_int_equal(poll(&told, 1, -1), 1);
    usleep(rng_below(r, round % 4 == 0 ? 5000 : 30000));
}

// The session that was running when its owner was killed, taken up here.
static void assert_resumes(store *s, int32_t told)
{
    profile_session session = test_session(1, 1);
    profile_resumed resumed;
    must(profile_session_resume(s, &session, &resumed, ERR));
    if (resumed.claim == PROFILE_CLAIM_NONE) {
        assert_int_equal(told, 0); // killed before it had begun
        return;
    }
    assert_int_equal(resumed.claim, PROFILE_CLAIM_RESUMED);
    int64_t trials;
    must(sql_find(s, "SELECT count(*) FROM trial WHERE session_id = ?", resumed.id, &trials, ERR));
    assert_in_range(trials, told, told + 1);
    must(profile_session_end(s, resumed.id, "failed", ERR));
}

TEST(a_killed_writer_loses_at_most_one_trial)
{
    test_folder folder = test_folder_make();
    rng r = rng_seed(test_seed());
    int64_t trials = 0;
    for (int round = 0; round < KILLS; ++round) {
        assert_int_equal(pipe(told_pipe), 0);
        pid_t child = start(write_until_killed, folder.store, 0);
        await_death(round, &r);
        assert_int_equal(kill(child, SIGKILL), 0);
        assert_int_equal(waitpid(child, NULL, 0), child);
        int32_t told = last_told();
        store *s = must(store_open(folder.store, STORE_WRITE, ERR));
        assert_true(test_count(s, "trial") >= trials + told);
        trials = test_count(s, "trial");
        assert_resumes(s, told);
        assert_sound(s);
        store_close(s);
    }
    assert_true(trials > 0);
    print_message("%" PRId64 " trials survived %d kills\n", trials, KILLS);
}

// A killed writer leaves side files; a look-up still sees what it had stored.
TEST(a_look_up_works_after_a_kill)
{
    test_folder folder = test_folder_make();
    assert_int_equal(pipe(told_pipe), 0);
    pid_t child = start(write_until_killed, folder.store, 0);
    int32_t told = 0;
    while (told < 3)
        assert_int_equal(read(told_pipe[0], &told, sizeof told), sizeof told);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    close(told_pipe[0]);
    close(told_pipe[1]);
    profile_request request = test_usual_request(1000);
    profile_found found;
    own(text) why = {0};
    must(profile_lookup_files(folder.store, NULL, &request, &found, &why, ERR));
    assert_says(text_chars(&why), "this workload was never measured on these two");
}
