// SPDX-License-Identifier: MIT
// tree:ray_query: which boxes rays meet.
#include "lua/nouns.h"

#include <string.h>

typedef struct query_box {
    duet_ray_query *query;
} query_box;

static const lua_class query_class;

static const member def_members[] = {
    MEMBER_ENUM(duet_ray_query_def, wants, query_wants_name),
    {0},
};

static const member result_members[] = {
    MEMBER(member_count, duet_ray_query_result, undecided),
    MEMBER(member_double, duet_ray_query_result, total_ms),
    MEMBER(member_double, duet_ray_query_result, device_ms),
    {0},
};

// tree:ray_query(def)
int ray_query_create_lua(lua_State *L)
{
    duet_error err = {0};
    duet_ray_query_def def = duet_default_ray_query_def();
    def.tree = tree_check(L, 1);
    if (!lua_isnoneornil(L, 2))
        member_read_table(L, 2, "a ray query", def_members, &def);
    query_box *box = class_push(L, &query_class, sizeof *box);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    box->query = duet_ray_query_create(&def, &err);
    return box->query ? 1 : class_push_failure(L, &err);
}

static duet_ray_query *query_check(lua_State *L)
{
    query_box *box = luaL_checkudata(L, 1, query_class.name);
    luaL_argcheck(L, box->query, 1, "the query is closed");
    return box->query;
}

// query:run(rays) -> hits, result
static int query_run(lua_State *L)
{
    duet_error err = {0};
    duet_ray_query_result result = {0};
    duet_ray_query *query = query_check(L);
    const array *rays = array_check(L, 2, ARRAY_RAYS);
    if (!duet_ray_query_run(query, rays->rows, rays->n, &result, &err))
        return class_push_failure(L, &err);
    array *hits = array_push(L, ARRAY_HITS, result.n_hits);
    if (result.n_hits > 0)
        memcpy(hits->rows, result.hits, (size_t)result.n_hits * sizeof *result.hits);
    member_push_table(L, result_members, &result);
    return 2;
}

static int query_close(lua_State *L)
{
    query_box *box = luaL_checkudata(L, 1, query_class.name);
    duet_ray_query_destroy(box->query);
    box->query = NULL;
    return 0;
}

static const luaL_Reg methods[] = {{"close", query_close}, {"run", query_run}, {NULL, NULL}};
static const lua_class query_class = {.name = "duet.ray_query", .methods = methods};

void ray_query_open_lua(lua_State *L)
{
    class_open(L, &query_class);
}
