// SPDX-License-Identifier: MIT
#include "tuner/search.h"

bool search_begin(search *s, const char *name, const search_options *options, duet_error *err)
{
    *s = (search){.strategy = strategy_find(name)};
    if (!strategy_check(name, err))
        return false;
    if (s->strategy->choice != STRATEGY_SHARE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "strategy '%s' chooses kernels too; expected one for the share alone",
                         name);
    search_options *own = &s->history.options;
    *own = options ? *options : search_default_options();
    if (own->quantum == 0)
        own->quantum = 1;
    return true;
}

void search_end(search *s)
{
    search_history_free(&s->history);
    *s = (search){0};
}

static uint32_t most_launches(const search *s)
{
    return s->history.options.launches ? s->history.options.launches : s->strategy->launches;
}

bool search_ask(const search *s, search_next *next, duet_error *err)
{
    *next = (search_next){.done = true};
    uint32_t most = most_launches(s);
    if (most && s->history.n >= most)
        return true;
    return s->strategy->ask(&s->history, next, err);
}

bool search_tell(search *s, const search_sample *sample, duet_error *err)
{
    return search_history_add(&s->history, sample, err);
}

uint32_t search_pick(const search *s)
{
    return s->history.n ? s->strategy->pick(&s->history) : 0;
}

void search_bracket(const search *s, uint32_t *low, uint32_t *high)
{
    *low = 0;
    *high = SEARCH_ONE;
    if (s->strategy->bracket)
        s->strategy->bracket(&s->history, low, high);
}
