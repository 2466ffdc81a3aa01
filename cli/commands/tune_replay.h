// SPDX-License-Identifier: MIT
// duet tune --replay: what strategies would have found on the launches that a store keeps.
#ifndef CLI_TUNE_REPLAY_H
#define CLI_TUNE_REPLAY_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct replay_options {
    const char *store;
    const char *scene; // its name in the store; NULL: all
    const int64_t *numbers;
    uint32_t n_numbers;        // numbers of objects, or items; 0: all
    const char *strategy;      // NULL: each
    const char *strategy_path; // the script that is then the strategy
    uint64_t repeats;          // see duet_tune_def
    uint64_t seed;
    bool json;
} replay_options;

bool tune_replay(const replay_options *options, duet_error *err);

#endif
