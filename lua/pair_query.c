// SPDX-License-Identifier: MIT
// device_pair:query: the narrow phase alone, for pairs that a script brings.
#include "lua/nouns.h"

CLASS_DESTROY(pair_query)
static const lua_class query_class = {
    .name = "duet.pair_query", .destroy = destroy_pair_query, .noun = "query"};

static const field def_fields[] = {
    FIELD(field_share, duet_pair_query_def, share),
    FIELD_ENUM(duet_pair_query_def, level, level_name),
    FIELDS(duet_pair_query_def, dims),
    {0},
};

// device_pair:query(def); the share is that of the pair's default plan.
static int device_pair_query(lua_State *L)
{
    duet_error err = {0};
    duet_device_pair *pair = device_pair_check(L);
    duet_pair_query_def def = duet_default_pair_query_def();
    def.pair = pair;
    def.share = duet_default_plan(pair).share;
    field_read(L, 2, "a pair query", def_fields, &def);
    lua_handle *query = class_push_of(L, &query_class, sizeof *query, 1);
    query->object = duet_pair_query_create(&def, &err);
    return query->object ? 1 : class_push_failure(L, &err);
}

// query:run(poses, with_separations) -> answers, result, separations
static int pair_query_run(lua_State *L)
{
    duet_error err = {0};
    duet_pair_query_result result = {0};
    duet_pair_query *query = class_object(L, 1, &query_class);
    const array *poses = array_check(L, 2, ARRAY_POSES);
    luaL_argcheck(L, poses->n % 2 == 0, 2, "an even number of rows: two a pair");
    bool with_separations = lua_toboolean(L, 3);
    uint64_t n = poses->n / 2;
    array *answers = array_push(L, ARRAY_ANSWERS, n);
    array *separations = array_push(L, ARRAY_SEPARATIONS, with_separations ? n : 0);
    if (!duet_pair_query_run(query, poses->rows, n, answers->rows,
                             with_separations ? separations->rows : NULL, &result, &err))
        return class_push_failure(L, &err);
    field_push_table(
        L, FIELD_LIST(duet_pair_query_result, colliding, undecided, total_ms, device_ms), &result);
    if (with_separations)
        lua_insert(L, -2);
    else
        lua_replace(L, -2);
    return with_separations ? 3 : 2;
}

const lua_noun pair_query_noun = {
    {&query_class},
    (const lua_method[]){METHODS(device_pair, query), METHODS(pair_query, run), {0}}};
