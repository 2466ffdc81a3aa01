// SPDX-License-Identifier: MIT
#include "tuner/race.h"

#include "base/rng.h"

#include <assert.h>
#include <math.h>

race_options race_default_options(void)
{
    return (race_options){
        .least_rounds = 8, .most_rounds = 20, .confidence = 0.99, .dropped = 1.03, .margin = 0.03};
}

const char *race_verdict_name(race_verdict verdict)
{
    static const char *const names[] = {"faster", "same", "slower", "ambiguous"};
    return names[verdict];
}

race_gain race_no_gain(race_verdict verdict)
{
    return (race_gain){.verdict = verdict, .ratio = 1, .interval = {1, 1, 1}};
}

race race_begin(uint32_t n, const race_options *options)
{
    assert(n > 0 && n <= RACE_RIVALS);
    race r = {.options = options ? *options : race_default_options(), .n = n};
    assert(r.options.least_rounds > 0 && r.options.most_rounds <= RACE_ROUNDS);
    return r;
}

static race_verdict judge(stats_interval in, double confidence)
{
    if (in.confidence < confidence)
        return RACE_AMBIGUOUS;
    if (in.low > 1)
        return RACE_FASTER;
    return in.high < 1 ? RACE_SLOWER : RACE_SAME;
}

uint32_t race_rounds(const race *r, uint32_t rival, uint32_t other)
{
    uint32_t n = r->rivals[rival].rounds, m = r->rivals[other].rounds;
    return n < m ? n : m;
}

race_gain race_compare(const race *r, uint32_t rival, uint32_t other)
{
    const double *own = r->rivals[rival].ns, *others = r->rivals[other].ns;
    uint32_t n = race_rounds(r, rival, other);
    double ratios[RACE_ROUNDS];
    for (uint32_t i = 0; i < n; ++i)
        ratios[i] = others[i] / own[i];
    race_gain gain = {.ratio = stats_median(ratios, n)};
    gain.interval = stats_median_interval(ratios, n, r->options.confidence);
    gain.verdict = judge(gain.interval, r->options.confidence);
    return gain;
}

// Rivals that are in have run this round or the one before it.
static uint32_t fewest_rounds(const race *r)
{
    uint32_t fewest = RACE_ROUNDS;
    for (uint32_t i = 0; i < r->n; ++i) {
        if (!r->rivals[i].out && r->rivals[i].rounds < fewest)
            fewest = r->rivals[i].rounds;
    }
    return fewest;
}

static bool race_alone(const race *r)
{
    uint32_t in = 0;
    for (uint32_t i = 0; i < r->n; ++i)
        in += !r->rivals[i].out;
    return in <= 1;
}

static bool round_is_over(const race *r)
{
    uint32_t round = fewest_rounds(r);
    for (uint32_t i = 0; i < r->n; ++i) {
        if (!r->rivals[i].out && r->rivals[i].rounds != round)
            return false;
    }
    return round >= r->options.least_rounds;
}

// How far all are behind the leader: more launches would not tell anything worth
// one. An interval may be wider the further it is from 1.
static bool all_are_known(const race *r)
{
    uint32_t leader = race_leader(r);
    if (r->options.margin <= 0 || !round_is_over(r))
        return false;
    for (uint32_t i = 0; i < r->n; ++i) {
        if (i == leader || r->rivals[i].out)
            continue;
        race_gain gain = race_compare(r, leader, i);
        double widest = fmax(pow(1 + r->options.margin, 2), sqrt(gain.interval.low));
        if (gain.verdict == RACE_AMBIGUOUS || gain.interval.high > widest * gain.interval.low)
            return false;
    }
    return true;
}

// Returns the rival's turn in a round; the same each time it is asked.
static uint32_t turn_of(uint32_t rival, uint32_t round)
{
    rng r = rng_seed((uint64_t)round << 32 | rival);
    return rng_next(&r);
}

bool race_next(const race *r, uint32_t *rival)
{
    uint32_t round = fewest_rounds(r);
    bool decided = round > 0 && (race_alone(r) || all_are_known(r));
    if (decided || round >= r->options.most_rounds)
        return false;
    *rival = r->n;
    for (uint32_t i = 0; i < r->n; ++i) {
        if (r->rivals[i].out || r->rivals[i].rounds != round)
            continue;
        if (*rival == r->n || turn_of(i, round) < turn_of(*rival, round))
            *rival = i;
    }
    return *rival < r->n;
}

double race_median(const race *r, uint32_t rival)
{
    return stats_median(r->rivals[rival].ns, r->rivals[rival].rounds);
}

static bool beats(const race *r, uint32_t rival, uint32_t other)
{
    return other == r->n || race_compare(r, rival, other).ratio > 1;
}

// The best of those that are in, from one of them on; n if there is none.
static uint32_t leader_from(const race *r, uint32_t from)
{
    uint32_t leader = r->n;
    for (uint32_t i = from; i < r->n; ++i) {
        if (!r->rivals[i].out && r->rivals[i].rounds > 0 && beats(r, i, leader))
            leader = i;
    }
    return leader;
}

uint32_t race_leader(const race *r)
{
    return leader_from(r, 0);
}

uint32_t race_best(const race *r, uint32_t from, uint32_t to)
{
    uint32_t best = r->n;
    for (uint32_t i = from; i < to; ++i) {
        if (r->rivals[i].rounds > 0 && beats(r, i, best))
            best = i;
    }
    return best == r->n ? to : best;
}

// The best of those that may leave; the usual one unless another is faster for sure.
static uint32_t choose(const race *r)
{
    uint32_t best = leader_from(r, r->options.stay), usual = r->options.usual;
    bool stays = usual > 0 && best < r->n && !r->rivals[usual].out &&
                 race_compare(r, best, usual).verdict != RACE_FASTER;
    return stays ? usual : best;
}

static void drop_slower(race *r)
{
    bool one = r->options.chosen_after > 0 && fewest_rounds(r) >= r->options.chosen_after;
    uint32_t leader = race_leader(r), chosen = one ? choose(r) : r->n;
    for (uint32_t i = r->options.stay; i < r->n; ++i) {
        if (i == leader || r->rivals[i].out)
            continue;
        race_gain gain = race_compare(r, leader, i);
        bool slower = gain.verdict == RACE_FASTER && gain.interval.low > r->options.dropped;
        r->rivals[i].out = slower || (one && i != chosen);
    }
}

void race_add(race *r, uint32_t rival, double ns)
{
    assert(rival < r->n && r->rivals[rival].rounds < RACE_ROUNDS);
    r->rivals[rival].ns[r->rivals[rival].rounds++] = ns;
    if (round_is_over(r))
        drop_slower(r);
}

void race_drop(race *r, uint32_t rival)
{
    r->rivals[rival].out = true;
}

race_gain race_compare_apart(const double *own, uint32_t n_own, const double *others,
                             uint32_t n_others, double confidence)
{
    // Both hold at once with that confidence if each misses half as often.
    double each = 1 - (1 - confidence) / 2;
    stats_interval mine = stats_median_interval(own, n_own, each);
    stats_interval theirs = stats_median_interval(others, n_others, each);
    race_gain gain = {.ratio = stats_median(others, n_others) / stats_median(own, n_own)};
    gain.interval = (stats_interval){.low = theirs.low / mine.high,
                                     .high = theirs.high / mine.low,
                                     .confidence = mine.confidence + theirs.confidence - 1};
    gain.verdict = judge(gain.interval, confidence);
    return gain;
}
