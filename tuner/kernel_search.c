// SPDX-License-Identifier: MIT
#include "tuner/kernel_search.h"

#include <math.h>

static const double BEHIND = 1.07; // in times of the fastest
static const double AHEAD = 1.02;  // a value must gain this much: between equal values noise would
                                   // choose, and the next parameter's best may not suit them

kernel_search kernel_search_begin(const kernel_space *space)
{
    kernel_search s = {.space = space, .best = space->now, .best_ns = INFINITY, .tried = 1};
    s.seen[space->now] = true;
    return s;
}

uint32_t kernel_search_distance(const kernel_space *space, uint32_t config, uint32_t other)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < space->n_params; ++i)
        n += space->configs[config][i] != space->configs[other][i];
    return n;
}

// Returns the config with that value of the parameter that is nearest to the best config: if the
// value is not valid beside the best config's other values, some of these differ too.
static uint32_t nearest_with(const kernel_search *s, uint32_t param, uint32_t value)
{
    uint32_t nearest = s->best, least = UINT32_MAX;
    for (uint32_t i = 0; i < s->space->n_configs; ++i) {
        uint32_t away = kernel_search_distance(s->space, s->best, i);
        if (s->space->configs[i][param] == value && away < least) {
            least = away;
            nearest = i;
        }
    }
    return nearest;
}

static uint32_t list_rivals(kernel_search *s, uint32_t configs[KERNEL_SPACE_VALUES])
{
    uint32_t n = 1;
    configs[0] = s->best;
    for (uint32_t value = 0; value < s->space->params[s->param].n_values; ++value) {
        uint32_t config = nearest_with(s, s->param, value);
        if (s->seen[config] || s->behind[s->param][value])
            continue;
        s->seen[config] = true;
        configs[n++] = config;
    }
    s->tried += n - 1;
    return n;
}

// Lists those of few configs that were not met either: the best of them may differ in several
// values from any that was raced.
static uint32_t list_left(kernel_search *s, uint32_t configs[KERNEL_SPACE_VALUES])
{
    uint32_t n = 1;
    configs[0] = s->best;
    for (uint32_t i = 0; s->space->n_configs <= s->few && i < s->space->n_configs; ++i) {
        if (s->seen[i] || n == KERNEL_SPACE_VALUES)
            continue;
        s->seen[i] = true;
        configs[n++] = i;
    }
    s->tried += n - 1;
    return n > 1 ? n : 0;
}

uint32_t kernel_search_next(kernel_search *s, uint32_t configs[KERNEL_SPACE_VALUES])
{
    while (s->idle < s->space->n_params) {
        uint32_t n = list_rivals(s, configs);
        if (n > 1)
            return n;
        ++s->idle;
        s->param = (s->param + 1) % s->space->n_params;
    }
    return list_left(s, configs);
}

void kernel_search_tell(kernel_search *s, const uint32_t *configs, const double *times, uint32_t n)
{
    uint32_t fastest = 0;
    for (uint32_t i = 1; i < n; ++i)
        if (times[i] < times[fastest])
            fastest = i;
    for (uint32_t i = 0; i < n; ++i)
        s->behind[s->param][s->space->configs[configs[i]][s->param]] =
            !(times[i] <= BEHIND * times[fastest]);
    if (!(AHEAD * times[fastest] < times[0]))
        fastest = 0;
    s->best = configs[fastest];
    s->best_ns = times[fastest];
    s->idle = 1;
    s->param = (s->param + 1) % s->space->n_params;
}
