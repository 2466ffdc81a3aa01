// SPDX-License-Identifier: MIT
// world:load_profile: the plan that is known for a world's objects.
#include "lua/nouns.h"
#include "lua/policy.h"

static const char *grade_name(int grade)
{
    return duet_grade_name((duet_grade)grade);
}

static const member profile_members[] = {
    MEMBER_ENUM(duet_profile, grade, grade_name),   MEMBER(member_plan, duet_profile, plan),
    MEMBER_ENUM(duet_profile, level, level_name),   MEMBER(member_accuracy, duet_profile, accuracy),
    MEMBER(member_count, duet_profile, true_pairs), MEMBER(member_double, duet_profile, step_ms),
    MEMBER(member_double, duet_profile, gain),      MEMBER(member_double, duet_profile, gain_low),
    MEMBER(member_double, duet_profile, gain_high), MEMBER(member_chars, duet_profile, verdict),
    MEMBER(member_int, duet_profile, measured_s),   {0},
};

int world_load_profile_lua(lua_State *L)
{
    duet_error err = {0};
    duet_profile profile;
    world_box *box = world_check(L, 1);
    const char *path = luaL_optstring(L, 2, NULL);
    if (path)
        policy_check_read(L, path);
    if (!duet_world_load_profile(box->world, path, &profile, &err))
        return class_push_failure(L, &err);
    member_push_table(L, profile_members, &profile);
    return 1;
}
