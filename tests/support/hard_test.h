// SPDX-License-Identifier: MIT
// Hard pairs through the narrow phase alone, on both devices.
#ifndef TESTS_HARD_TEST_H
#define TESTS_HARD_TEST_H

#include "runtime/duet.h"

// Tests so many pairs of each hard class at every level, on A, on B and on both
// at once, as they are, exchanged, and with -q for q. Each answer must be what
// the level promises, what its specification in C says, and everywhere the same;
// else a line is printed that repeats the pair, and the test fails.
void hard_test_run(uint32_t dims, int each);

// One level's answers of n pairs; A has the share.
void hard_test_answers(duet_level level, uint32_t dims, uint32_t share, const duet_pose *poses,
                       uint64_t n, uint8_t *answers, duet_pair_query_result *result);

#endif
