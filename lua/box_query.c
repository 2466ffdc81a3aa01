// SPDX-License-Identifier: MIT
// tree:box_query: which objects of a tree other boxes collide with.
#include "lua/nouns.h"

#include <string.h>

typedef struct query_box {
    duet_box_query *query;
    array_kind takes;
} query_box;

static const lua_class query_class;

static const member def_members[] = {
    MEMBER_ENUM(duet_box_query_def, level, level_name),
    {0},
};

static const member result_members[] = {
    MEMBER(member_count, duet_box_query_result, undecided),
    MEMBER(member_double, duet_box_query_result, total_ms),
    MEMBER(member_double, duet_box_query_result, device_ms),
    {0},
};

// tree:box_query(def)
int box_query_create_lua(lua_State *L)
{
    duet_error err = {0};
    duet_box_query_def def = duet_default_box_query_def();
    def.tree = tree_check(L, 1);
    if (!lua_isnoneornil(L, 2))
        member_read_table(L, 2, "a box query", def_members, &def);
    query_box *box = class_push(L, &query_class, sizeof *box);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    box->takes = tree_array_kind(L, 1);
    box->query = duet_box_query_create(&def, &err);
    return box->query ? 1 : class_push_failure(L, &err);
}

static int push_hits(lua_State *L, const duet_box_query_result *result)
{
    array *hits = array_push(L, ARRAY_BOX_HITS, result->n_hits);
    if (result->n_hits > 0)
        memcpy(hits->rows, result->hits, (size_t)result->n_hits * sizeof *result->hits);
    member_push_table(L, result_members, result);
    return 2;
}

// query:run(boxes) -> hits, result
static int query_run(lua_State *L)
{
    duet_error err = {0};
    duet_box_query_result result = {0};
    query_box *box = luaL_checkudata(L, 1, query_class.name);
    luaL_argcheck(L, box->query, 1, "the query is closed");
    const array *boxes = array_check(L, 2, box->takes);
    duet_object_kind kind = box->takes == ARRAY_POSES ? DUET_OBJECT_POSES : DUET_OBJECT_BOUNDS;
    if (!duet_box_query_run(box->query, kind, boxes->rows, boxes->n, &result, &err))
        return class_push_failure(L, &err);
    return push_hits(L, &result);
}

// query:run_itself(filters) -> hits, result
static int query_run_itself(lua_State *L)
{
    duet_error err = {0};
    duet_box_query_result result = {0};
    query_box *box = luaL_checkudata(L, 1, query_class.name);
    luaL_argcheck(L, box->query, 1, "the query is closed");
    const array *filters = lua_isnoneornil(L, 2) ? NULL : array_check(L, 2, ARRAY_FILTERS);
    if (!duet_box_query_run_itself(box->query, filters ? filters->rows : NULL,
                                   filters ? filters->n : 0, &result, &err))
        return class_push_failure(L, &err);
    return push_hits(L, &result);
}

static int query_close(lua_State *L)
{
    query_box *box = luaL_checkudata(L, 1, query_class.name);
    duet_box_query_destroy(box->query);
    box->query = NULL;
    return 0;
}

static const luaL_Reg methods[] = {
    {"close", query_close}, {"run", query_run}, {"run_itself", query_run_itself}, {NULL, NULL}};
static const lua_class query_class = {.name = "duet.box_query", .methods = methods};

void box_query_open_lua(lua_State *L)
{
    class_open(L, &query_class);
}
