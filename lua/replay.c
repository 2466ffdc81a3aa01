// SPDX-License-Identifier: MIT
// duet.replay: recorded commands, given to a motion again.
#include "lua/nouns.h"
#include "lua/policy.h"

CLASS_DESTROY(replay)
static const lua_class replay_class = {
    .name = "duet.replay", .destroy = destroy_replay, .noun = "replay"};

// duet.replay(path)
static int create(lua_State *L)
{
    duet_error err = {0};
    const char *path = text_check(L, 1);
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
static int replay_advance(lua_State *L)
{
    return motion_advance_by(L, 2, advance_by_replay, class_object(L, 1, &replay_class));
}

// replay:info() -> { steps, commands, steps_done }
static int replay_info(lua_State *L)
{
    const duet_replay_info i = duet_replay_get_info(class_object(L, 1, &replay_class));
    field_push_table(L, FIELD_LIST(duet_replay_info, steps, commands, steps_done), &i);
    return 1;
}

const lua_noun replay_noun = {
    {&replay_class},
    (const lua_method[]){{"duet.replay", create, 0}, METHODS(replay, advance, info), {0}}};
