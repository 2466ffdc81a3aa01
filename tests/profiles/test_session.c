// SPDX-License-Identifier: MIT
// A search that was stopped, and who may take it up.
#define _GNU_SOURCE
#include "support/test.h"

#include "profiles/sql.h"
#include "support/store.h"

#include <sys/wait.h>
#include <unistd.h>

// A store that was tuned, with another session of the same search under way.
typedef struct search {
    store *s;
    profile_session session;
    char id[PROFILE_ID];
} search;

static search search_begun(void)
{
    search begun = {.s = test_store_tuned(), .session = test_session(1, 1)};
    must(profile_session_begin(begun.s, &begun.session, begun.id, ERR));
    return begun;
}

static profile_resumed resume(store *s, const profile_session *session)
{
    profile_resumed resumed;
    must(profile_session_resume(s, session, &resumed, ERR));
    return resumed;
}

// ----------------------------------------------------------------------- sessions

TEST(a_stopped_session_is_resumed)
{
    store *s = test_store_tuned();
    profile_session session = test_session(1, 1);
    assert_int_equal(resume(s, &session).claim, PROFILE_CLAIM_NONE); // the tuned one is complete
    char id[PROFILE_ID];
    must(profile_session_begin(s, &session, id, ERR));
    profile_resumed resumed = resume(s, &session);
    assert_int_equal(resumed.claim, PROFILE_CLAIM_BUSY); // this process lives
    assert_int_equal(resumed.pid, getpid());
    must(profile_session_end(s, id, "stopped", ERR));
    resumed = resume(s, &session);
    assert_int_equal(resumed.claim, PROFILE_CLAIM_RESUMED);
    assert_string_equal(resumed.id, id);
}

// Trials that a resumed search did not take again are no part of it.
TEST(a_trial_takes_the_place_of_those_from_its_number_on)
{
    search begun = search_begun();
    for (int i = 0; i < 5; ++i) {
        profile_sample samples[2];
        profile_trial trial = test_trial(1000, i / 8.0, samples, 2);
        must(profile_trial_add(begun.s, begun.id, i, &trial, ERR));
    }
    int64_t others = test_count(begun.s, "trial"), launches = test_count(begun.s, "sample");
    profile_sample samples[3];
    profile_trial trial = test_trial(1000, 0.75, samples, 3);
    must(profile_trial_add(begun.s, begun.id, 2, &trial, ERR));
    assert_int_equal(test_count(begun.s, "trial"), others - 2);
    assert_int_equal(test_count(begun.s, "sample"), launches - 3);
    assert_int_equal(test_count(begun.s, "trial WHERE share = 49152 AND number = 2"), 1);
    must(profile_trial_drop(begun.s, begun.id, 1, ERR));
    assert_int_equal(test_count(begun.s, "trial"), others - 4);
}

TEST(another_search_is_not_resumed)
{
    search begun = search_begun();
    must(profile_session_end(begun.s, begun.id, "stopped", ERR));
    profile_session others[5] = {begun.session, begun.session, begun.session, begun.session,
                                 begun.session};
    others[0].strategy = "golden";
    others[1].kernels = "changed";
    others[2].seed = 2;
    others[3].options = "{\"launches\":17}";
    others[4].objective = "energy";
    for (int i = 0; i < 5; ++i)
        assert_int_equal(resume(begun.s, &others[i]).claim, PROFILE_CLAIM_NONE);
}

// The question is part of what is finished.
TEST(what_was_asked_and_finished_is_known)
{
    store *s = test_store_tuned();
    char uid[PROFILE_ID];
    profile_session session = test_session(1, 1);
    session.script = "return { n = 1000 } -- a word that changes nothing";
    must(profile_session_known(s, &session, uid, ERR));
    assert_int_equal(strlen(uid), PROFILE_ID - 1);
    must(sql_script(s, "UPDATE profile SET live = 0, dead_reason = 'replaced'", ERR));
    must(profile_session_known(s, &session, uid, ERR));
    assert_int_equal(strlen(uid), PROFILE_ID - 1);
    must(sql_script(s, "UPDATE session SET strategy = 'lua'", ERR));
    profile_session others[6] = {session, session, session, session, session, session};
    others[0].strategy = "grid";
    others[1].kernels = "changed";
    others[2].seed = 2;
    others[3].options = "{\"launches\":17}";
    others[4].strategy = "lua"; // and another script
    others[5].strategy = "lua";
    others[5].script = NULL;
    for (int i = 0; i < 6; ++i) {
        must(profile_session_known(s, &others[i], uid, ERR));
        assert_string_equal(uid, "");
    }
    others[5].script = test_session(1, 1).script;
    must(profile_session_known(s, &others[5], uid, ERR));
    assert_int_equal(strlen(uid), PROFILE_ID - 1);
}

TEST(one_process_measures_a_workload_whatever_it_asks)
{
    store *s = test_store_fresh();
    profile_pair pair = test_pair(), swapped = {.a = pair.b, .b = pair.a};
    profile_workload workloads[2] = {test_workload(1000), test_workload(2000)};
    int64_t pairs[2], ids[2];
    must(profile_pair_put(s, &pair, &pairs[0], ERR));
    must(profile_pair_put(s, &swapped, &pairs[1], ERR));
    for (int i = 0; i < 2; ++i)
        must(profile_workload_put(s, &workloads[i], &ids[i], ERR));
    char id[PROFILE_ID];
    profile_session session = test_session(pairs[0], ids[0]);
    must(profile_session_begin(s, &session, id, ERR));
    profile_session others[4] = {session, session, session, session};
    others[0].options = "{\"launches\":17}";
    others[1].strategy = "grid";
    others[2].pair_id = pairs[1];
    others[3].workload_id = ids[1];
    for (int i = 0; i < 4; ++i)
        assert_int_equal(resume(s, &others[i]).claim,
                         i < 3 ? PROFILE_CLAIM_BUSY : PROFILE_CLAIM_NONE);
    // On another machine another pair is no disturbance.
    must(sql_script(s, "UPDATE session SET host = 'elsewhere'", ERR));
    for (int i = 0; i < 3; ++i)
        assert_int_equal(resume(s, &others[i]).claim,
                         i < 2 ? PROFILE_CLAIM_BUSY : PROFILE_CLAIM_NONE);
}

TEST(a_dead_owners_session_is_resumed)
{
    static const char *const owners[] = {
        "UPDATE session SET pid_start = pid_start + 1",            // the number went to another
        "UPDATE session SET pid = 999999999",                      // no such process
        "UPDATE session SET host = 'elsewhere', heartbeat_ns = 1", // long silent
    };
    for (size_t i = 0; i < sizeof owners / sizeof owners[0]; ++i) {
        search begun = search_begun();
        must(sql_script(begun.s, owners[i], ERR));
        profile_resumed resumed = resume(begun.s, &begun.session);
        assert_int_equal(resumed.claim, PROFILE_CLAIM_RESUMED);
        assert_string_equal(resumed.id, begun.id);
    }
}

TEST(a_silent_owner_elsewhere_is_given_ten_minutes)
{
    search begun = search_begun();
    must(sql_script(begun.s, "UPDATE session SET host = 'elsewhere', pid = 999999999", ERR));
    assert_int_equal(resume(begun.s, &begun.session).claim, PROFILE_CLAIM_BUSY);
}
