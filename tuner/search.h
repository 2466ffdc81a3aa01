// SPDX-License-Identifier: MIT
// A search for the share, or for kernels and share together: samples in, the next plan to measure
// out.
//
// A search is its strategy, what that may choose from and the samples that it was told, in order,
// and nothing else: a strategy is a pure function of it. So a search that is begun again and told
// the same goes on exactly as if it had never stopped.
#ifndef TUNER_SEARCH_H
#define TUNER_SEARCH_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

#define SEARCH_ONE 65536u // the whole work; shares are out of it

enum { SEARCH_KERNELS = 8 }; // that a search varies on a device; others keep their config

// One launch: the share that A took, the configs of both devices' kernels and the wall-clock times.
// A plan to try has no times.
typedef struct search_sample {
    uint32_t share;
    uint64_t total_ns;
    uint64_t a_ns; // 0 if the device took no part
    uint64_t b_ns;
    uint16_t configs[2 * SEARCH_KERNELS]; // for the kernels in the search's space
    bool failed;                          // it did not run, or found what is wrong
} search_sample;

// Says which launch a strategy wants next, or none.
typedef struct search_next {
    bool done;
    search_sample at;
} search_next;

typedef struct search_options {
    uint32_t launches; // at most so many; 0: the strategy's own number
    uint32_t quantum;  // shares nearer than this are the same; a work-group's part
    uint32_t points;   // grid: intervals between 0 and 1
    uint32_t rounds;   // grid: how often it goes over all of them
    uint32_t start;    // a neighbouring workload's share: begin near it; 0: none is known
    double probe_cost; // balance: no launch that is expected to take longer than
                       // this many times share 0
} search_options;

search_options search_default_options(void);

bool search_is_shared(uint32_t share); // both devices have a part

typedef struct search {
    const struct strategy *strategy;
    search_options options;
    struct script *script;           // only strategy lua has it; borrowed
    const struct joint_space *space; // kernels to choose from; may be NULL; borrowed
    uint64_t seed;
    search_sample *samples; // in the order they were measured
    uint32_t n;
} search;

// strategy.h begins one.
void search_end(search *s);

bool search_ask(const search *s, search_next *next, duet_error *err);
bool search_tell(search *s, const search_sample *sample, duet_error *err);

// The share to use after what was told so far; 0 before anything was.
uint32_t search_pick(const search *s);

// Returns the range in which the strategy knows or believes the best share to lie, ends included;
// the whole range if the strategy keeps no bracket.
void search_bracket(const search *s, uint32_t *low, uint32_t *high);

// Returns the first sample of that share, or of that plan; NULL if there is none.
const search_sample *search_at(const search *s, uint32_t share);
const search_sample *search_find(const search *s, const search_sample *plan);

// Returns the share of the quickest sample, of one or more: the pick of strategies that trust
// single samples.
uint32_t search_fastest(const search *s);

// The first share that both take part in: the neighbour's, or 1/16, which is
// large against overheads and 16 times cheaper than all.
uint32_t search_first_share(const search *s);

// Returns the medians of the times of n > 0 samples, of one plan.
search_sample search_samples_median(const search_sample *samples, uint32_t n);

#endif
