// SPDX-License-Identifier: MIT
// duet.replay: recorded commands, given to a motion again.
#include "lua/nouns.h"
#include "lua/policy.h"

typedef struct replay_box {
    duet_replay *replay;
} replay_box;

static const lua_class replay_class;

// duet.replay(path)
static int create(lua_State *L)
{
    duet_error err = {0};
    const char *path = luaL_checkstring(L, 1);
    policy_check_read(L, path);
    replay_box *box = class_push(L, &replay_class, sizeof *box);
    box->replay = duet_replay_create(path, &err);
    return box->replay ? 1 : class_push_failure(L, &err);
}

static duet_replay *check_replay(lua_State *L)
{
    replay_box *box = luaL_checkudata(L, 1, replay_class.name);
    luaL_argcheck(L, box->replay, 1, "the replay is closed");
    return box->replay;
}

static bool advance_by_replay(void *by, duet_motion *motion, duet_motion_result *result,
                              duet_error *err)
{
    return duet_replay_advance(by, motion, result, err);
}

// replay:advance(motion) -> the step's result
static int advance(lua_State *L)
{
    return motion_advance_by(L, 2, advance_by_replay, check_replay(L));
}

static const member info_members[] = {
    MEMBER(member_count, duet_replay_info, steps),
    MEMBER(member_count, duet_replay_info, commands),
    MEMBER(member_count, duet_replay_info, steps_done),
    {0},
};

// replay:info() -> { steps, commands, steps_done }
static int info(lua_State *L)
{
    const duet_replay_info i = duet_replay_get_info(check_replay(L));
    member_push_table(L, info_members, &i);
    return 1;
}

static int replay_close(lua_State *L)
{
    replay_box *box = luaL_checkudata(L, 1, replay_class.name);
    duet_replay_destroy(box->replay);
    box->replay = NULL;
    return 0;
}

static const luaL_Reg methods[] = {
    {"close", replay_close}, {"advance", advance}, {"info", info}, {NULL, NULL}};
static const lua_class replay_class = {.name = "duet.replay", .methods = methods};

void replay_open_lua(lua_State *L)
{
    static const luaL_Reg functions[] = {{"replay", create}, {NULL, NULL}};
    class_open(L, &replay_class);
    luaL_setfuncs(L, functions, 0);
}
