// SPDX-License-Identifier: MIT
// A search for the share: samples in, the next share to measure out.
//
// A search is its strategy, its options and the samples it was told, and
// nothing else: a strategy is a pure function of these. So a search that is
// begun again and told the same goes on exactly as if it had never stopped.
#ifndef TUNER_SEARCH_H
#define TUNER_SEARCH_H

#include "base/error.h"
#include "base/text.h"

#include <stdbool.h>
#include <stdint.h>

#define SEARCH_ONE 65536u // the whole work; shares are out of it

// One launch: the share that A took and the wall-clock times.
typedef struct search_sample {
    uint32_t share;
    uint64_t total_ns;
    uint64_t a_ns; // 0 where the device took no part
    uint64_t b_ns;
} search_sample;

typedef struct search_options {
    uint32_t launches; // at most so many; 0: the strategy's own number
    uint32_t quantum;  // shares nearer than this are the same; a work-group's part
    uint32_t points;   // grid: intervals between 0 and 1
    uint32_t rounds;   // grid: how often it goes over all of them
    bool has_start;    // start is a neighbouring workload's share: begin near it
    uint32_t start;
    double probe_cost; // balance: no launch that is expected to take longer than
                       // this many times share 0
} search_options;

search_options search_default_options(void);

typedef struct search search;
typedef struct strategy strategy;

// What a strategy wants: another launch, or none.
typedef struct search_next {
    bool done;
    uint32_t share;
} search_next;

struct search {
    const strategy *strategy;
    search_options options;
    search_sample *samples; // in the order they were measured
    uint32_t n;
    uint32_t capacity;
    void *script; // of strategy lua only; borrowed
};

// NOT_FOUND for an unknown strategy: the line lists those there are. options
// NULL: the default ones.
bool search_begin(search *s, const char *strategy, const search_options *options, duet_error *err);
void search_end(search *s);

bool search_ask(const search *s, search_next *next, duet_error *err);
bool search_tell(search *s, const search_sample *sample, duet_error *err);

// The share to use after what was told so far; 0 before anything was.
uint32_t search_pick(const search *s);

// Where the strategy knows or believes the best share to lie, ends included.
// The whole range for one that keeps no bracket.
void search_bracket(const search *s, uint32_t *low, uint32_t *high);

// Helps for strategies.
const search_sample *search_at(const search *s, uint32_t share); // first there; NULL for none

// The first share that both take part in: the neighbour's, or 1/16, which is
// large against overheads and 16 times cheaper than all.
uint32_t search_first_share(const search *s);

#endif
