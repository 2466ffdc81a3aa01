// SPDX-License-Identifier: MIT
#include "support/recorded.h"

#include "support/store.h"
#include "support/test.h"

record test_record(store *s)
{
    static profile_pair pair;
    static profile_workload workload;
    pair = test_pair();
    workload = test_workload(1000);
    record r = {.store = s};
    profile_request request = test_request(&pair, &workload);
    must(record_aim(&r, &request, ERR));
    profile_session session = test_session(r.pair_id, r.workload_id);
    profile_resumed found;
    must(profile_session_resume(s, &session, &found, ERR));
    assert_int_not_equal(found.claim, PROFILE_CLAIM_BUSY);
    memcpy(r.session, found.id, sizeof r.session);
    if (found.claim == PROFILE_CLAIM_NONE)
        must(profile_session_begin(s, &session, r.session, ERR));
    return r;
}

void test_record_again(const record *r, trial_log *log)
{
    trial_log_free(log);
    must(record_recall(r, log, ERR));
}
