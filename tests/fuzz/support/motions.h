// SPDX-License-Identifier: MIT
// Small motions whose saved states are fuzzed: between them they keep every
// buffer that a state can have.
#ifndef TESTS_FUZZ_MOTIONS_H
#define TESTS_FUZZ_MOTIONS_H

#include "runtime/duet.h"

enum { MOTIONS = 5 };

// On the devices that a world gets by default; NULL and the error's line where
// that fails.
duet_device_pair *motions_open_pair(duet_error *err);
duet_motion *motions_make(int which, duet_device_pair *pair, duet_error *err);

#endif
