// SPDX-License-Identifier: MIT
// The arguments of `duet tune`, and its way with --replay.
#ifndef CLI_TUNE_H
#define CLI_TUNE_H

#include "cli/inputs.h"

typedef struct arguments {
    scene_options scene;
    const char *config;
    const char *task;
    const char *numbers;
    const char *pair;
    const char *strategy;
    const char *strategy_path;
    const char *objective;
    const char *search;
    const char *query;
    uint64_t items;
    uint64_t steps;
    const char *variants;
    level_options level;
    double budget_seconds;
    uint64_t budget_trials;
    uint64_t repeats;
    double wait_seconds;
    const char *store;
    const char *replay;
    bool ordered;
    bool fresh;
    bool keep;
    bool json;
} arguments;

enum { MOST_NUMBERS = 64 };

typedef struct number_list {
    int64_t items[MOST_NUMBERS];
    uint32_t n;
} number_list;

// Tells what strategies would have found on the launches that a store keeps of a scene (its name in
// the store; NULL: all) with these numbers of objects, or items (none: all).
bool tune_replay(const arguments *args, const char *scene, const number_list *numbers,
                 duet_error *err);

#endif
