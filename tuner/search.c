// SPDX-License-Identifier: MIT
#include "tuner/search.h"

#include "base/list.h"
#include "tuner/stats.h"
#include "tuner/strategy.h"

#include <stdlib.h>
#include <string.h>

bool search_is_shared(uint32_t share)
{
    return share > 0 && share < SEARCH_ONE;
}

search_options search_default_options(void)
{
    return (search_options){.quantum = 8, .points = 32, .rounds = 3, .probe_cost = 3.0};
}

void search_end(search *s)
{
    free(s->samples);
    *s = (search){0};
}

bool search_ask(const search *s, search_next *next, duet_error *err)
{
    uint32_t most = s->options.launches ? s->options.launches : s->strategy->launches;
    *next = (search_next){.done = true};
    return (most && s->n >= most) || s->strategy->ask(s, next, err);
}

bool search_tell(search *s, const search_sample *sample, duet_error *err)
{
    search_sample *samples = list_room(s->samples, s->n, sizeof *samples, err);
    if (!samples)
        return false;
    s->samples = samples;
    s->samples[s->n++] = *sample;
    return true;
}

uint32_t search_pick(const search *s)
{
    return s->n ? s->strategy->pick(s) : 0;
}

void search_bracket(const search *s, uint32_t *low, uint32_t *high)
{
    *low = 0;
    *high = SEARCH_ONE;
    if (s->strategy->bracket)
        s->strategy->bracket(s, low, high);
}

const search_sample *search_at(const search *s, uint32_t share)
{
    for (uint32_t i = 0; i < s->n; ++i) {
        if (s->samples[i].share == share)
            return &s->samples[i];
    }
    return NULL;
}

const search_sample *search_find(const search *s, const search_sample *plan)
{
    for (uint32_t i = 0; i < s->n; ++i)
        if (s->samples[i].share == plan->share &&
            memcmp(s->samples[i].configs, plan->configs, sizeof plan->configs) == 0)
            return &s->samples[i];
    return NULL;
}

uint32_t search_first_share(const search *s)
{
    uint32_t start = s->options.start;
    return search_is_shared(start) ? start : SEARCH_ONE / 16;
}

uint32_t search_fastest(const search *s)
{
    const search_sample *fastest = &s->samples[0];
    for (uint32_t i = 1; i < s->n; ++i) {
        if (s->samples[i].total_ns < fastest->total_ns)
            fastest = &s->samples[i];
    }
    return fastest->share;
}

search_sample search_samples_median(const search_sample *samples, uint32_t n)
{
    double ns[3][STATS_MOST];
    search_sample median = samples[0];
    for (uint32_t i = 0; i < n; ++i) {
        ns[0][i] = (double)samples[i].total_ns;
        ns[1][i] = (double)samples[i].a_ns;
        ns[2][i] = (double)samples[i].b_ns;
    }
    median.total_ns = (uint64_t)stats_median(ns[0], n);
    median.a_ns = (uint64_t)stats_median(ns[1], n);
    median.b_ns = (uint64_t)stats_median(ns[2], n);
    return median;
}
