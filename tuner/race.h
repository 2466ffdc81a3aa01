// SPDX-License-Identifier: MIT
// A race between plans: measured in turn, round by round, until the interval
// of the ratio to the leader says which is slower.
//
// Samples are only ever compared with those of the same round, so that a slow
// minute falls on all rivals alike. Each round has an order of its own, so
// that what one plan leaves in caches and clocks does not always meet the same
// other plan.
#ifndef TUNER_RACE_H
#define TUNER_RACE_H

#include "tuner/stats.h"

enum { RACE_RIVALS = 32, RACE_ROUNDS = 100 };

typedef struct race_options {
    uint32_t least_rounds; // before any plan drops out
    uint32_t most_rounds;  // up to RACE_ROUNDS
    double confidence;     // the intervals' confidence
    double dropped;        // a plan that surely takes so many times the leader's time drops out
    uint32_t stay;         // the first so many rivals do not: others are measured by them
    uint32_t chosen_after; // so many rounds, one of the others is left; 0: as many as there are
    uint32_t usual;        // that one, unless another is faster for sure; 0: none
    double margin;         // the race ends once all ratios are known this well; 0: it does not
} race_options;

// 8 rounds, all won by one side, are the fewest that give 99 %. More rounds are not spent on
// plans within 3 % of each other, and no plan drops out for less: asked after every round,
// one of two equal plans is ahead by a little sooner or later.
race_options race_default_options(void);

typedef struct race {
    race_options options;
    uint32_t n; // rivals
    struct {
        bool out;
        uint32_t rounds;
        double ns[RACE_ROUNDS];
    } rivals[RACE_RIVALS];
} race;

typedef enum race_verdict {
    RACE_FASTER,
    RACE_SAME, // the interval holds 1
    RACE_SLOWER,
    RACE_AMBIGUOUS // too few rounds for an interval of that confidence
} race_verdict;

const char *race_verdict_name(race_verdict verdict); // "faster"

// How many times faster a rival is than another.
typedef struct race_gain {
    race_verdict verdict;
    double ratio; // 1.25: a quarter faster
    stats_interval interval;
} race_gain;

race_gain race_no_gain(race_verdict verdict); // neither is faster

race race_begin(uint32_t n, const race_options *options); // NULL: the default ones

// Finds the rival to measure next; false if the race is over: one rival is left, it is known how
// far all are behind the leader, or the rounds are used up.
bool race_next(const race *r, uint32_t *rival);

// Adds a rival's time for the round. After the last of a round, rivals that
// are clearly slower than the leader are out.
void race_add(race *r, uint32_t rival, double ns);

// A rival that cannot run at all.
void race_drop(race *r, uint32_t rival);

// Returns the best rival still in; n if all are out.
uint32_t race_leader(const race *r);

// Returns the best of rivals from .. to - 1, in or out: the one that is mostly faster than another
// in the same round; `to` if none has run.
uint32_t race_best(const race *r, uint32_t from, uint32_t to);

// Rounds that both ran.
uint32_t race_rounds(const race *r, uint32_t rival, uint32_t other);

double race_median(const race *r, uint32_t rival);

// Compares over the rounds that both ran; at least one.
race_gain race_compare(const race *r, uint32_t rival, uint32_t other);

// Compares times that were measured apart, at another time or place: the
// interval is as wide as those of both medians together, and a machine that
// was slower for another reason is not told from a slower program.
race_gain race_compare_apart(const double *own, uint32_t n_own, const double *others,
                             uint32_t n_others, double confidence);

#endif
