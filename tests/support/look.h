// SPDX-License-Identifier: MIT
// Look-ups for tests: an open store to tune into and to look up in.
#ifndef TESTS_LOOK_H
#define TESTS_LOOK_H

#include "support/store.h"

typedef struct look_fixture {
    test_folder folder;
    store *s;
    profile_pair pair;
} look_fixture;

look_fixture look_open(void); // its store is open until the test ends

void look_tune(look_fixture *f, uint64_t n); // a session for the test's workload of n objects
void look_change(look_fixture *f, const char *statements);

void look_assert_why(store *s, const profile_request *request, const char *says);
// Looks up in two files as test_pair's application does; either may be NULL.
profile_found look_in_files(const char *user, const char *system, uint64_t n);
profile_found look_up(store *s, const profile_request *request);
profile_found look_for(look_fixture *f, const profile_pair *pair, uint64_t n);

#endif
