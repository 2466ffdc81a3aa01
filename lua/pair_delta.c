// SPDX-License-Identifier: MIT
// duet.pair_delta: which pairs of a still world began and ended between two steps.
#include "lua/nouns.h"

CLASS_DESTROY(pair_delta)
static const lua_class delta_class = {
    .name = "duet.pair_delta", .destroy = destroy_pair_delta, .noun = "delta"};

// duet.pair_delta()
static int create(lua_State *L)
{
    duet_error err = {0};
    lua_handle *delta = class_push(L, &delta_class, sizeof *delta);
    delta->object = duet_pair_delta_create(&err);
    return delta->object ? 1 : class_push_failure(L, &err);
}

static void push_events(lua_State *L, const duet_pair_delta_result *result, bool begins)
{
    uint64_t n = 0;
    for (uint64_t i = 0; i < result->n_events; ++i)
        n += result->events[i].begins == begins;
    duet_pair *to = array_push(L, ARRAY_PAIRS, n)->rows;
    for (uint64_t i = 0; i < result->n_events; ++i)
        if (result->events[i].begins == begins)
            *to++ = (duet_pair){result->events[i].a, result->events[i].b};
}

// delta:update(pairs) -> begun, ended, stays
static int pair_delta_update(lua_State *L)
{
    duet_error err = {0};
    duet_pair_delta_result result = {0};
    duet_pair_delta *delta = class_object(L, 1, &delta_class);
    const array *pairs = array_check(L, 2, ARRAY_PAIRS);
    const duet_span spans[2] = {{pairs->rows, pairs->n}, {NULL, 0}};
    if (!duet_pair_delta_update(delta, spans, &result, &err))
        return class_push_failure(L, &err);
    push_events(L, &result, true);
    push_events(L, &result, false);
    array_push_copy(L, ARRAY_PAIRS, result.stays, result.n_stays);
    return 3;
}

const lua_noun pair_delta_noun = {
    {&delta_class},
    (const lua_method[]){{"duet.pair_delta", create, 0}, METHODS(pair_delta, update), {0}}};
