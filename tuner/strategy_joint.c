// SPDX-License-Identifier: MIT
// The strategies that choose kernels and share together.
#include "tuner/joint_space.h"
#include "tuner/strategy.h"

#include <math.h>

// ---------------------------------------------------------------- brute

static bool ask_brute(const search *h, search_next *next, duet_error *err)
{
    (void)err;
    *next = (search_next){.done = h->n >= joint_space_count(h->space)};
    if (!next->done)
        next->at = joint_space_at(h->space, h->n);
    return true;
}

const strategy strategy_brute = {
    .name = "brute",
    .about = "every plan: all configs of both devices at every share of an even grid",
    .choice = STRATEGY_JOINT_ALL,
    .evened = true,
    .ask = ask_brute,
};

// ---------------------------------------------------------------- random

enum { TRIES = 1000 }; // until nearly all plans have been measured

static bool ask_random(const search *h, search_next *next, duet_error *err)
{
    (void)err;
    rng r = rng_stream(h->seed, h->n);
    next->done = true;
    for (int i = 0; next->done && i < TRIES; ++i) {
        next->at = joint_space_random(h->space, &r);
        next->done = search_find(h, &next->at);
    }
    return true;
}

const strategy strategy_random = {
    .name = "random",
    .about = "plans by chance, none twice",
    .choice = STRATEGY_JOINT,
    .evened = true,
    .ask = ask_random,
};

// ---------------------------------------------------------------- annealing

// Simulated annealing (Kirkpatrick et al. 1983) on the ratio of times. It begins with the configs
// that ran at first at a quarter, for a device that is slower is the usual case. Plans that were
// measured are not measured again: the walk over them is played from the start each time. When it
// is caught among them, plans by chance follow.
static const double WARMEST = 0.3, COLDEST = 0.005; // in parts of the time

static double cost_of(const search_sample *sample)
{
    return sample->failed ? INFINITY : (double)sample->total_ns;
}

static bool is_accepted(double now, double then, double part, rng *r)
{
    double chance = rng_unit(r);
    if (then <= now)
        return true;
    double warmth = WARMEST * pow(COLDEST / WARMEST, part);
    return isfinite(then) && chance < exp(-(then / now - 1) / warmth);
}

static bool ask_annealing(const search *h, search_next *next, duet_error *err)
{
    rng r = rng_stream(h->seed, 0);
    search_sample at = joint_space_base(h->space, h->space->points ? SEARCH_ONE / 4 : 0);
    const search_sample *now = search_find(h, &at), *seen;
    *next = (search_next){.at = at};
    if (!now)
        return true;
    for (uint32_t i = 0, reached = 0; i < TRIES + 16 * h->n; ++i) {
        next->at = joint_space_neighbour(h->space, now, &r);
        seen = search_find(h, &next->at);
        if (!seen)
            return true;
        uint32_t place = (uint32_t)(seen - h->samples);
        reached = place > reached ? place : reached; // the latest plan so far says how cool it is
        double part = h->options.launches ? (double)reached / h->options.launches : 1;
        if (is_accepted(cost_of(now), cost_of(seen), part, &r))
            now = seen;
    }
    return ask_random(h, next, err);
}

const strategy strategy_annealing = {
    .name = "annealing",
    .about = "simulated annealing: from plan to neighbouring plan, at first to slower ones too",
    .choice = STRATEGY_JOINT,
    .evened = true,
    .ask = ask_annealing,
};
