// SPDX-License-Identifier: MIT
// Commands for tests: what names bodies, and worlds that get some.
#ifndef TESTS_COMMANDS_H
#define TESTS_COMMANDS_H

#include "support/mover.h"
#include "support/test.h"

#include <string.h>

duet_body_list one(uint32_t place);
duet_body_list by_ids(const uint64_t *ids, uint32_t n);

// Fails unless a call is refused with a line that has these words.
#define assert_refused(call, words)                       \
    do {                                                  \
        duet_error err = {0};                             \
        assert_false(call);                               \
        if (!strstr(err.text, words))                     \
            fail_msg("%s is told '%s'", #call, err.text); \
    } while (0)

#define assert_done(call)     \
    do {                      \
        duet_error err = {0}; \
        assert_ok(call, err); \
    } while (0)

// Rows of unit cubes on a floor, that rest soon; place 0 is the floor.
mover *make_rows(uint32_t n, uint32_t high);

#endif
