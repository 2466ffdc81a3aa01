// SPDX-License-Identifier: MIT
// A tuning's record in a store of a test's own, as `duet tune` keeps one.
#ifndef TESTS_RECORDED_H
#define TESTS_RECORDED_H

#include "tuner/record.h"

// Begins a session in the store for test_pair and test_workload, or takes up the one that is there.
record test_record(store *s);

// Does as a process that was killed and is started again: all that is left of the log is in the
// store.
void test_record_again(const record *r, trial_log *log);

#endif
