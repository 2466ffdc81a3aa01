// SPDX-License-Identifier: MIT
// A plan is a table: { share = 0.25, mode = "own", variant_a = ..., variant_b = ... }.
#include "lua/nouns.h"

static const char *mode_name(int mode)
{
    return duet_mode_name((duet_mode)mode);
}

static const member plan_members[] = {
    MEMBER(member_share, duet_plan, share),
    MEMBER_ENUM(duet_plan, mode, mode_name),
    MEMBER(member_chars, duet_plan, variant_a),
    MEMBER(member_chars, duet_plan, variant_b),
    {0},
};

// What is not in the table stays as the plan has it.
static void read_plan(lua_State *L, const member *m, void *at)
{
    if (!lua_istable(L, -1))
        member_refuse(L, m, "a table");
    member_read_table(L, -1, "a plan", plan_members, at);
}

static void push_plan(lua_State *L, const member *m, const void *at)
{
    (void)m;
    member_push_table(L, plan_members, at);
}

const member_type member_plan = {read_plan, push_plan};

// The modes there are.
static int modes(lua_State *L)
{
    lua_newtable(L);
    for (int mode = 0; mode_name(mode); ++mode) {
        lua_pushstring(L, mode_name(mode));
        lua_rawseti(L, -2, mode + 1);
    }
    return 1;
}

void plan_open_lua(lua_State *L)
{
    static const luaL_Reg functions[] = {{"modes", modes}, {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
