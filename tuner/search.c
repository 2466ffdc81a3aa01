// SPDX-License-Identifier: MIT
#include "tuner/search.h"

#include "base/budget.h"
#include "tuner/strategy.h"

#include <inttypes.h>
#include <stdlib.h>

search_options search_default_options(void)
{
    return (search_options){.quantum = 8, .points = 32, .rounds = 3, .probe_cost = 3.0};
}

static bool fail_unknown(const char *name, duet_error *err)
{
    text known = {0};
    for (uint32_t i = 0; strategies[i]; ++i)
        text_add(&known, "%s%s", i ? ", " : "", strategies[i]->name);
    error_set(err, DUET_STATUS_NOT_FOUND, "strategy '%s': there is none; there are %s", name,
              text_chars(&known));
    text_free(&known);
    return false;
}

bool search_begin(search *s, const char *name, const search_options *options, duet_error *err)
{
    *s = (search){.strategy = strategy_find(name)};
    if (!s->strategy)
        return fail_unknown(name, err);
    s->options = options ? *options : search_default_options();
    if (s->options.quantum == 0)
        s->options.quantum = 1;
    return true;
}

void search_end(search *s)
{
    free(s->samples);
    *s = (search){0};
}

static uint32_t most_launches(const search *s)
{
    return s->options.launches ? s->options.launches : s->strategy->launches;
}

bool search_ask(const search *s, search_next *next, duet_error *err)
{
    *next = (search_next){.done = true};
    uint32_t most = most_launches(s);
    if (most && s->n >= most)
        return true;
    return s->strategy->ask(s, next, err);
}

bool search_tell(search *s, const search_sample *sample, duet_error *err)
{
    if (s->n == s->capacity) {
        uint32_t capacity = s->capacity ? 2 * s->capacity : 32;
        if (!budget_space(capacity * sizeof *s->samples, err))
            return false;
        search_sample *grown = realloc(s->samples, capacity * sizeof *grown);
        if (!grown)
            return error_set(err, DUET_STATUS_NO_MEMORY,
                             "a search of %" PRIu32 " launches: no memory", s->n + 1);
        s->samples = grown;
        s->capacity = capacity;
    }
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

uint32_t search_first_share(const search *s)
{
    bool near = s->options.has_start && s->options.start > 0 && s->options.start < SEARCH_ONE;
    return near ? s->options.start : SEARCH_ONE / 16;
}
