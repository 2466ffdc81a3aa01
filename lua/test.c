// SPDX-License-Identifier: MIT
// device_pair:test: the narrow phase alone, for pairs that a script brings.
#include "lua/nouns.h"

typedef struct test_box {
    duet_test *test;
} test_box;

static const lua_class test_class;

static const member def_members[] = {
    MEMBER(member_share, duet_test_def, share),
    MEMBER_ENUM(duet_test_def, level, level_name),
    MEMBER(member_count, duet_test_def, dims),
    {0},
};

static const member result_members[] = {
    MEMBER(member_count, duet_test_result, colliding),
    MEMBER(member_count, duet_test_result, undecided),
    MEMBER(member_double, duet_test_result, total_ms),
    MEMBER(member_double, duet_test_result, device_ms),
    {0},
};

// device_pair:test(def); the share is that of the pair's default plan.
int test_open_from_lua(lua_State *L)
{
    duet_error err = {0};
    duet_device_pair *pair = device_pair_check(L, 1);
    duet_test_def def = duet_default_test_def();
    def.pair = pair;
    def.share = duet_default_plan(pair).share;
    if (!lua_isnoneornil(L, 2))
        member_read_table(L, 2, "a test", def_members, &def);
    test_box *box = class_push(L, &test_class, sizeof *box);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    box->test = duet_test_open(&def, &err);
    return box->test ? 1 : class_push_failure(L, &err);
}

// test:pairs(poses, with_separations) -> verdicts, result, separations
static int test_pairs(lua_State *L)
{
    duet_error err = {0};
    duet_test_result result = {0};
    test_box *box = luaL_checkudata(L, 1, test_class.name);
    luaL_argcheck(L, box->test, 1, "the test is closed");
    const array *poses = array_check(L, 2, ARRAY_POSES);
    luaL_argcheck(L, poses->n % 2 == 0, 2, "an even number of rows: two a pair");
    bool with_separations = lua_toboolean(L, 3);
    uint64_t n = poses->n / 2;
    array *verdicts = array_push(L, ARRAY_VERDICTS, n);
    array *separations = array_push(L, ARRAY_SEPARATIONS, with_separations ? n : 0);
    if (!duet_test_pairs(box->test, poses->rows, n, verdicts->rows,
                         with_separations ? separations->rows : NULL, &result, &err))
        return class_push_failure(L, &err);
    member_push_table(L, result_members, &result);
    if (with_separations)
        lua_insert(L, -2);
    else
        lua_replace(L, -2);
    return with_separations ? 3 : 2;
}

static int test_close(lua_State *L)
{
    test_box *box = luaL_checkudata(L, 1, test_class.name);
    if (!box->test)
        return 0;
    duet_test_close(box->test);
    box->test = NULL;
    return 0;
}

static const luaL_Reg methods[] = {{"close", test_close}, {"pairs", test_pairs}, {NULL, NULL}};
static const lua_class test_class = {.name = "duet.test", .methods = methods};

void test_open_lua(lua_State *L)
{
    class_open(L, &test_class);
}
