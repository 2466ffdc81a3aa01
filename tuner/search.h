// SPDX-License-Identifier: MIT
// A search for the share: samples in, the next share to measure out.
//
// A search is its strategy and its history, and nothing else: a strategy is a
// pure function of the history. So a search that is begun again and told the
// same goes on exactly as if it had never stopped.
#ifndef TUNER_SEARCH_H
#define TUNER_SEARCH_H

#include "tuner/strategy.h"

typedef struct search {
    const strategy *strategy;
    search_history history;
} search;

// BAD_ARGUMENT for an unknown strategy: the line lists those there are. options
// NULL: the default ones.
bool search_begin(search *s, const char *strategy, const search_options *options, duet_error *err);
void search_end(search *s);

bool search_ask(const search *s, search_next *next, duet_error *err);
bool search_tell(search *s, const search_sample *sample, duet_error *err);

// The share to use after what was told so far; 0 before anything was.
uint32_t search_pick(const search *s);

// Returns the range in which the strategy knows or believes the best share to lie, ends included;
// the whole range if the strategy keeps no bracket.
void search_bracket(const search *s, uint32_t *low, uint32_t *high);

#endif
