// SPDX-License-Identifier: MIT
// A search for a kernel's fastest config: which ones to race next, from what the races
// before showed.
//
// One parameter after the other is varied, the others staying as they are best so far
// (coordinate descent), until a whole round of parameters brings nothing new. A value
// that was clearly behind is not tried again beside other values of the others, but of few configs
// all are tried in the end.
#ifndef TUNER_KERNEL_SEARCH_H
#define TUNER_KERNEL_SEARCH_H

#include "runtime/broadphase/kernel_space.h"

typedef struct kernel_search {
    const kernel_space *space;
    uint32_t best;  // config
    double best_ns; // by the race before; INFINITY: it was in none
    uint32_t param; // to be varied next
    uint32_t idle;  // parameters in a row that brought nothing new to try
    uint32_t tried; // configs, the one at the start counted
    uint32_t few;   // configs, of which each is tried in the end; 0: never
    bool seen[KERNEL_SPACE_CONFIGS];
    bool behind[KERNEL_SPACE_PARAMS][KERNEL_SPACE_VALUES];
} kernel_search;

// Counts the parameters in which two configs differ.
uint32_t kernel_search_distance(const kernel_space *space, uint32_t config, uint32_t other);

// The space must live as long as the search.
kernel_search kernel_search_begin(const kernel_space *space);

// The configs to race: the best one so far, then others that were never raced: those that differ
// from it in one parameter, or in the end what is left. Returns how many; 0: the search is done.
uint32_t kernel_search_next(kernel_search *s, uint32_t configs[KERNEL_SPACE_VALUES]);

// Reports what that race showed: how long each config takes, INFINITY if it could not run.
void kernel_search_tell(kernel_search *s, const uint32_t *configs, const double *times, uint32_t n);

#endif
