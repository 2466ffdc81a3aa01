// SPDX-License-Identifier: MIT
// What a step found. The pairs stay in the world's memory: a result holds
// until the world's next step, and result:copy() for ever.
#include "lua/nouns.h"

typedef struct result_box {
    duet_result result;
    const world_box *world; // the uservalue's
    uint64_t step;
} result_box;

static const lua_class result_class;

static const field result_fields[] = {
    FIELDS(duet_result, objects, bad, first_bad, candidates, undecided, total_ms, device_ms,
           kernel_ms, bytes, cells, cell, cell_widened, grid_levels, hashed, runs, timed),
    {0},
};

static const char *device_letter(int value)
{
    static const char *const names[] = {"A", "B"};
    return value < 2 ? names[value] : NULL;
}

static const field stage_fields[] = {
    FIELDS(duet_stage, name),
    FIELD_ENUM(duet_stage, device, device_letter),
    FIELDS(duet_stage, ms, transfer, begin_ms, end_ms),
    {0},
};

void result_push(lua_State *L, int world_index, const duet_result *result)
{
    world_index = lua_absindex(L, world_index);
    result_box *box = class_push_of(L, &result_class, sizeof *box, world_index);
    box->result = *result;
    box->world = lua_touserdata(L, world_index);
    box->step = box->world->steps;
}

static void check_step(lua_State *L, const result_box *box)
{
    luaL_argcheck(L, box->world, 1, "the result is closed");
    luaL_argcheck(L, box->world->world, 1, "the result's world is closed");
    luaL_argcheck(L, box->world->steps == box->step, 1,
                  "the world was stepped again: a result holds until then");
}

static const duet_result *check_result(lua_State *L)
{
    const result_box *box = luaL_checkudata(L, 1, result_class.name);
    check_step(L, box);
    return &box->result;
}

static const void *struct_of(lua_State *L)
{
    return check_result(L);
}

static int result_length(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)check_result(L)->pairs);
    return 1;
}

static int result_pair(lua_State *L)
{
    const duet_result *result = check_result(L);
    lua_Integer i = luaL_checkinteger(L, 2);
    luaL_argcheck(L, i >= 0 && (uint64_t)i < result->pairs, 2, "a place below #result, from 0");
    duet_pair pair = duet_result_get_pair(result, (uint64_t)i);
    lua_pushinteger(L, pair.a);
    lua_pushinteger(L, pair.b);
    return 2;
}

// The next pair; upvalues: the result, the place.
static int next_pair(lua_State *L)
{
    const result_box *box = lua_touserdata(L, lua_upvalueindex(1));
    lua_Integer i = lua_tointeger(L, lua_upvalueindex(2));
    check_step(L, box);
    if ((uint64_t)i >= box->result.pairs)
        return 0;
    lua_pushinteger(L, i + 1);
    lua_replace(L, lua_upvalueindex(2));
    duet_pair pair = duet_result_get_pair(&box->result, (uint64_t)i);
    lua_pushinteger(L, pair.a);
    lua_pushinteger(L, pair.b);
    return 2;
}

static int result_pairs(lua_State *L)
{
    check_result(L);
    lua_pushvalue(L, 1);
    lua_pushinteger(L, 0);
    lua_pushcclosure(L, next_pair, 2);
    return 1;
}

static int result_copy(lua_State *L)
{
    const duet_result *result = check_result(L);
    array *a = array_push(L, ARRAY_PAIRS, result->pairs);
    duet_pair *to = a->rows;
    for (uint64_t i = 0; i < result->pairs; ++i)
        to[i] = duet_result_get_pair(result, i);
    return 1;
}

void stages_push(lua_State *L, const duet_stage *stages, uint32_t n)
{
    field_push_list(L, stage_fields, stages, n, sizeof *stages);
}

static int result_stages(lua_State *L)
{
    const duet_result *result = check_result(L);
    stages_push(L, result->stages, result->n_stages);
    return 1;
}

static int result_hash(lua_State *L)
{
    array_push_hash(L, duet_result_get_hash(check_result(L)));
    return 1;
}

static int result_close(lua_State *L)
{
    result_box *box = luaL_checkudata(L, 1, result_class.name);
    box->world = NULL;
    return 0;
}

static const lua_class result_class = {
    .name = "duet.result", .fields = result_fields, .struct_of = struct_of};

const lua_noun result_noun = {
    {&result_class},
    (const lua_method[]){METHODS(result, pair, pairs, copy, stages, hash, close),
                         {"duet.result:__len", result_length, 0},
                         {0}}};
