// SPDX-License-Identifier: MIT
// duet.search: a strategy's search for the share, asked and told by the script:
// on devices, on recorded times, or on an invented cost function.
#include "lua/nouns.h"
#include "lua/policy.h"

#include "tuner/strategy.h"

typedef struct search_box {
    search search;
    bool open;
} search_box;

static const lua_class search_class = {
    .name = "duet.search",
};

typedef struct search_def {
    const char *strategy;
    const char *strategy_lua; // text of the script that strategy "lua" runs
    search_options options;
} search_def;

static const field def_fields[] = {
    FIELDS(search_def, strategy, strategy_lua),
    FIELDS_IN(search_def, options., launches, points, rounds),
    FIELD_IN(field_share, search_def, options., quantum),
    FIELD_IN(field_share, search_def, options., start),
    FIELDS_IN(search_def, options., probe_cost),
    {0},
};

static search *check_search(lua_State *L)
{
    search_box *box = luaL_checkudata(L, 1, search_class.name);
    luaL_argcheck(L, box->open, 1, "the search is closed");
    return &box->search;
}

static int search_open(lua_State *L)
{
    duet_error err = {0};
    search_def def = {.strategy = strategies[0]->name, .options = search_default_options()};
    field_read(L, 1, "a search", def_fields, &def);
    if (def.strategy_lua)
        policy_check_trusted(L, "a search by strategy_lua");
    search_box *box = class_push(L, &search_class, sizeof *box);
    box->open = search_begin(&box->search, def.strategy, &def.options, &err);
    if (box->open && def.strategy_lua)
        box->search.script = strategy_lua_open("strategy", def.strategy_lua, &err);
    return err.status == DUET_STATUS_OK ? 1 : class_push_failure(L, &err);
}

static int search_close(lua_State *L)
{
    search_box *box = luaL_checkudata(L, 1, search_class.name);
    if (box->open) {
        script_close(box->search.script);
        search_end(&box->search);
    }
    box->open = false;
    return 0;
}

static void push_share(lua_State *L, uint32_t share)
{
    lua_pushnumber(L, (lua_Number)share / SEARCH_ONE);
}

// The share to measure next, or nothing once the search is done.
static int search_ask_lua(lua_State *L)
{
    duet_error err = {0};
    search_next next = {0};
    if (!search_ask(check_search(L), &next, &err))
        return class_push_failure(L, &err);
    if (next.done)
        return 0;
    push_share(L, next.at.share);
    return 1;
}

static uint64_t check_ns(lua_State *L, int index)
{
    lua_Number ms = luaL_checknumber(L, index);
    luaL_argcheck(L, ms >= 0 && ms < 1e12, index, "milliseconds from 0");
    return (uint64_t)(ms * 1e6);
}

// search:tell(share, total_ms, a_ms, b_ms)
static int search_tell_lua(lua_State *L)
{
    duet_error err = {0};
    search *s = check_search(L);
    lua_Number share = luaL_checknumber(L, 2);
    luaL_argcheck(L, share >= 0 && share <= 1, 2, "a part from 0 to 1");
    search_sample sample = {
        .share = (uint32_t)(share * SEARCH_ONE + 0.5),
        .total_ns = check_ns(L, 3),
        .a_ns = check_ns(L, 4),
        .b_ns = check_ns(L, 5),
    };
    return class_push_done(L, search_tell(s, &sample, &err), &err);
}

static int search_pick_lua(lua_State *L)
{
    push_share(L, search_pick(check_search(L)));
    return 1;
}

static int search_bracket_lua(lua_State *L)
{
    uint32_t low = 0;
    uint32_t high = 0;
    search_bracket(check_search(L), &low, &high);
    push_share(L, low);
    push_share(L, high);
    return 2;
}

const lua_noun search_noun = {{&search_class},
                              (const lua_method[]){{"duet.search", search_open, 0},
                                                   {"duet.search:ask", search_ask_lua, 0},
                                                   {"duet.search:tell", search_tell_lua, 0},
                                                   {"duet.search:pick", search_pick_lua, 0},
                                                   {"duet.search:bracket", search_bracket_lua, 0},
                                                   METHODS(search, close),
                                                   {0}}};
