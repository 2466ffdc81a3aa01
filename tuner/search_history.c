// SPDX-License-Identifier: MIT
#include "tuner/search_history.h"

#include "base/budget.h"
#include "tuner/stats.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

search_options search_default_options(void)
{
    return (search_options){.quantum = 8, .points = 32, .rounds = 3, .probe_cost = 3.0};
}

bool search_history_add(search_history *h, const search_sample *sample, duet_error *err)
{
    if (h->n == h->capacity) {
        uint32_t capacity = h->capacity ? 2 * h->capacity : 32;
        if (!budget_space(capacity * sizeof *h->samples, err))
            return false;
        search_sample *grown = realloc(h->samples, capacity * sizeof *grown);
        if (!grown)
            return error_set(err, DUET_STATUS_NO_MEMORY,
                             "a search of %" PRIu32 " launches: no memory", h->n + 1);
        h->samples = grown;
        h->capacity = capacity;
    }
    h->samples[h->n++] = *sample;
    return true;
}

void search_history_free(search_history *h)
{
    free(h->samples);
    *h = (search_history){0};
}

const search_sample *search_history_at(const search_history *h, uint32_t share)
{
    for (uint32_t i = 0; i < h->n; ++i) {
        if (h->samples[i].share == share)
            return &h->samples[i];
    }
    return NULL;
}

const search_sample *search_history_find(const search_history *h, const search_sample *plan)
{
    for (uint32_t i = 0; i < h->n; ++i)
        if (h->samples[i].share == plan->share &&
            memcmp(h->samples[i].configs, plan->configs, sizeof plan->configs) == 0)
            return &h->samples[i];
    return NULL;
}

uint32_t search_history_first_share(const search_history *h)
{
    bool near = h->options.has_start && h->options.start > 0 && h->options.start < SEARCH_ONE;
    return near ? h->options.start : SEARCH_ONE / 16;
}

uint32_t search_history_fastest(const search_history *h)
{
    const search_sample *fastest = &h->samples[0];
    for (uint32_t i = 1; i < h->n; ++i) {
        if (h->samples[i].total_ns < fastest->total_ns)
            fastest = &h->samples[i];
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
