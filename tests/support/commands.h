// SPDX-License-Identifier: MIT
// Commands for tests: what names bodies, and worlds that get some.
#ifndef TESTS_COMMANDS_H
#define TESTS_COMMANDS_H

#include "support/mover.h"
#include "support/test.h"

#include <string.h>

duet_body_list one(uint32_t place);
duet_body_list by_ids(const uint64_t *ids, uint32_t n);

// Rows of unit cubes on a floor, that rest soon; place 0 is the floor.
mover *make_rows(uint32_t n, uint32_t high);

#endif
