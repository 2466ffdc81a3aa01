// SPDX-License-Identifier: MIT
// duet.replay: recorded commands, given to a motion again.
#include "lua/nouns.h"
#include "lua/policy.h"

static const lua_class replay_class;

// duet.replay(path)
static int create(lua_State *L)
{
    duet_error err = {0};
    const char *path = luaL_checkstring(L, 1);
    policy_check_read(L, path);
    lua_handle *replay = class_push(L, &replay_class, sizeof *replay);
    replay->object = duet_replay_create(path, &err);
    return replay->object ? 1 : class_push_failure(L, &err);
}

static bool advance_by_replay(void *by, duet_motion *motion, duet_motion_result *result,
                              duet_error *err)
{
    return duet_replay_advance(by, motion, result, err);
}

// replay:advance(motion) -> the step's result
static int advance(lua_State *L)
{
    return motion_advance_by(L, 2, advance_by_replay, class_object(L, 1, &replay_class));
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
    const duet_replay_info i = duet_replay_get_info(class_object(L, 1, &replay_class));
    member_push_table(L, info_members, &i);
    return 1;
}

static void destroy(void *replay)
{
    duet_replay_destroy(replay);
}

static const luaL_Reg methods[] = {{"advance", advance}, {"info", info}, {NULL, NULL}};
static const lua_class replay_class = {
    .name = "duet.replay", .methods = methods, .destroy = destroy, .noun = "replay"};

void replay_open_lua(lua_State *L)
{
    static const luaL_Reg functions[] = {{"replay", create}, {NULL, NULL}};
    class_open(L, &replay_class);
    luaL_setfuncs(L, functions, 0);
}
