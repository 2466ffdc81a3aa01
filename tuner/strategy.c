// SPDX-License-Identifier: MIT
#include "tuner/strategy.h"

#include <string.h>

const strategy *const strategies[] = {
    &strategy_balance, &strategy_fig12,  &strategy_bisect, &strategy_golden,
    &strategy_grid,    &strategy_chunks, &strategy_lua,    NULL,
};

const strategy *strategy_at(uint32_t i)
{
    return i < sizeof strategies / sizeof strategies[0] ? strategies[i] : NULL;
}

const strategy *strategy_find(const char *name)
{
    for (uint32_t i = 0; strategies[i]; ++i) {
        if (strcmp(strategies[i]->name, name) == 0)
            return strategies[i];
    }
    return NULL;
}

uint32_t strategy_pick_fastest(const search *s)
{
    const search_sample *fastest = search_fastest(s);
    return fastest ? fastest->share : 0;
}
