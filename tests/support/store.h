// SPDX-License-Identifier: MIT
// Stores for tests: a folder of its own, and rows that look like real ones.
#ifndef TESTS_STORE_H
#define TESTS_STORE_H

#include "profiles/level_cost.h"
#include "profiles/lookup.h"

#define TEST_KERNELS "5b1d0c0ffee00000000000000000000000000000000000000000000000000001"

// A fresh folder, and a path in it.
typedef struct test_folder {
    char path[64];
    char store[96];     // PATH/profiles.db, not made yet
    char variable[112]; // DUET_PROFILE=that store, for programs
} test_folder;

test_folder test_folder_make(void);

store *test_store_open(const char *path, store_access access);
store *test_store_fresh(void); // in a folder of its own, open until the test ends
store *test_store_tuned(void); // the same with what test_tune_usual leaves
// Names the path, which is no store, and says so.
void test_store_refuses(const char *path, store_access access, duet_status status,
                        const char *says);
void test_store_run(const char *path, const char *statements); // past the store's own code

profile_pair test_pair(void);               // a CPU part as A and a GPU as B
profile_workload test_workload(uint64_t n); // at constant density
profile_session test_session(int64_t pair_id, int64_t workload_id);
profile_plan test_plan(double share);
profile_request test_request(const profile_pair *pair, const profile_workload *workload);
profile_request test_usual_request(uint64_t n); // of test_pair for test_workload(n)

// A trial at `share` with `n_samples` launches about what the two devices of
// test_time take; `samples` holds them.
profile_trial test_trial(uint64_t n, double share, profile_sample *samples, uint32_t n_samples);

// The time of a device for its part of n objects: affine, A five times slower.
double test_time(int device, uint64_t n, double share);

// A whole session of nine shares, 0 and 1 among them, with its profile.
void test_tune(store *s, const profile_pair *pair, const profile_workload *workload);

void test_tune_usual(store *s);         // test_pair's, of 1000 objects
void test_store_tune(const char *path); // the same in the store of that path
void test_fill_out(store *s);           // a table of level costs, and all that a profile can have

// Stores a plan that is faster by half, as a tuning would.
void test_store_plan(const char *path, const profile_pair *pair, const profile_workload *workload,
                     const char *kernels, const profile_plan *plan);

// n profiles of the test's pair, for workloads of 1000 + i objects, with the
// share i out of 65536.
void test_fill(store *s, uint32_t n);

int64_t test_count(store *s, const char *table);

#endif
