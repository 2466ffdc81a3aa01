// SPDX-License-Identifier: MIT
#include "tuner/joint_strategy.h"

#include "base/budget.h"
#include "base/text.h"
#include "tuner/strategy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- history

bool joint_history_add(joint_history *h, const joint_sample *sample, duet_error *err)
{
    if (h->n == h->capacity) {
        uint32_t capacity = h->capacity ? 2 * h->capacity : 64;
        if (!budget_space(capacity * sizeof *h->samples, err))
            return false;
        joint_sample *grown = realloc(h->samples, capacity * sizeof *grown);
        if (!grown)
            return error_set(err, DUET_STATUS_NO_MEMORY, "a search of %u plans: no memory",
                             h->n + 1);
        h->samples = grown;
        h->capacity = capacity;
    }
    h->samples[h->n++] = *sample;
    return true;
}

void joint_history_free(joint_history *h)
{
    free(h->samples);
    *h = (joint_history){0};
}

const joint_sample *joint_history_find(const joint_history *h, const joint_point *at)
{
    for (uint32_t i = 0; i < h->n; ++i)
        if (joint_point_same(&h->samples[i].at, at))
            return &h->samples[i];
    return NULL;
}

// ---------------------------------------------------------------- brute

static bool ask_brute(const joint_history *h, joint_next *next, duet_error *err)
{
    (void)err;
    *next = (joint_next){.done = h->n >= joint_space_count(h->space)};
    if (!next->done)
        next->at = joint_space_at(h->space, h->n);
    return true;
}

static const joint_strategy strategy_brute = {
    .name = "brute",
    .about = "every plan: all configs of both devices at every share of an even grid",
    .all = true,
    .ask = ask_brute,
};

// ---------------------------------------------------------------- random

enum { TRIES = 1000 }; // until nearly all plans have been measured

static bool ask_random(const joint_history *h, joint_next *next, duet_error *err)
{
    (void)err;
    rng r = rng_stream(h->seed, h->n);
    next->done = true;
    for (int i = 0; next->done && i < TRIES; ++i) {
        next->at = joint_space_random(h->space, &r);
        next->done = joint_history_find(h, &next->at);
    }
    return true;
}

static const joint_strategy strategy_random = {
    .name = "random",
    .about = "plans by chance, none twice",
    .ask = ask_random,
};

// ---------------------------------------------------------------- annealing

// Simulated annealing (Kirkpatrick et al. 1983) on the ratio of times. It begins with the configs
// that ran at first at a quarter, for a device that is slower is the usual case. Plans that were
// measured are not measured again: the walk over them is played from the start each time. Once it
// is caught among them, plans by chance follow.
static const double WARMEST = 0.3, COLDEST = 0.005; // in parts of the time

static double cost_of(const joint_sample *sample)
{
    return sample->usable ? (double)sample->times.total_ns : INFINITY;
}

static bool is_accepted(double now, double then, double part, rng *r)
{
    double chance = rng_unit(r);
    if (then <= now)
        return true;
    double warmth = WARMEST * pow(COLDEST / WARMEST, part);
    return isfinite(then) && chance < exp(-(then / now - 1) / warmth);
}

static bool ask_annealing(const joint_history *h, joint_next *next, duet_error *err)
{
    rng r = rng_stream(h->seed, 0);
    joint_point at = joint_space_base(h->space, h->space->points ? SEARCH_ONE / 4 : 0);
    const joint_sample *now = joint_history_find(h, &at), *seen;
    *next = (joint_next){.at = at};
    if (!now)
        return true;
    for (uint32_t i = 0, reached = 0; i < TRIES + 16 * h->n; ++i) {
        next->at = joint_space_neighbour(h->space, &now->at, &r);
        seen = joint_history_find(h, &next->at);
        if (!seen)
            return true;
        uint32_t place = (uint32_t)(seen - h->samples);
        reached = place > reached ? place : reached; // as cool as it was at the latest plan so far
        double part = h->most ? (double)reached / h->most : 1;
        if (is_accepted(cost_of(now), cost_of(seen), part, &r))
            now = seen;
    }
    return ask_random(h, next, err);
}

static const joint_strategy strategy_annealing = {
    .name = "annealing",
    .about = "simulated annealing: from plan to neighbouring plan, at first to slower ones too",
    .ask = ask_annealing,
};

// ---------------------------------------------------------------- the table

const joint_strategy *const joint_strategies[] = {&strategy_random, &strategy_annealing,
                                                  &strategy_brute, NULL};

const joint_strategy *joint_strategy_find(const char *name)
{
    const joint_strategy *const *at = joint_strategies;
    while (*at && strcmp((*at)->name, name) != 0)
        ++at;
    return *at;
}

const joint_strategy *joint_strategy_of(const char *name, script *own)
{
    bool joint = own && strcmp(name, strategy_lua.name) == 0 && strategy_lua_is_joint(own);
    return joint ? &joint_strategy_lua : joint_strategy_find(name);
}

uint32_t joint_strategy_samples(const joint_strategy *of, const joint_space *space)
{
    enum { LEAST = 24, MOST = 400, ALL = 100000 };
    uint64_t n = joint_space_count(space);
    if (of->all)
        return (uint32_t)(n < ALL ? n : ALL);
    return n / 10 < LEAST ? LEAST : n / 10 > MOST ? MOST : (uint32_t)(n / 10);
}

bool joint_strategy_check(const char *name, duet_error *err)
{
    if (strategy_find(name) || joint_strategy_find(name))
        return true;
    text known = {0};
    for (uint32_t i = 0; strategies[i]; ++i)
        text_add(&known, "%s%s", i ? ", " : "", strategies[i]->name);
    for (uint32_t i = 0; joint_strategies[i]; ++i)
        text_add(&known, "%s%s", i ? ", " : ", and for kernels and share together ",
                 joint_strategies[i]->name);
    error_set(err, DUET_STATUS_BAD_ARGUMENT, "strategy '%s': there is none; there are %s", name,
              text_chars(&known));
    text_free(&known);
    return false;
}
