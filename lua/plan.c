// SPDX-License-Identifier: MIT
// How a step is done: plans, { share = 0.25, mode = "own", variant_a = ..., variant_b = ... },
// and levels of accuracy, by their names.
#include "lua/nouns.h"

static const char *mode_name(int mode)
{
    return duet_mode_name((duet_mode)mode);
}

static const member plan_members[] = {
    MEMBER(member_share, duet_plan, share),
    MEMBER_ENUM(duet_plan, mode, mode_name),
    MEMBERS(duet_plan, variant_a, variant_b),
    {0},
};

const member_type member_plan = {member_read_struct, member_push_struct, plan_members, "a plan"};

void plan_read(lua_State *L, duet_plan *plan)
{
    static const member argument = {.name = "plan", .type = &member_plan};
    lua_settop(L, 2);
    member_read_struct(L, &argument, plan);
}

int plan_push(lua_State *L, const duet_plan *plan)
{
    if (plan)
        member_push_table(L, plan_members, plan);
    else
        lua_pushnil(L);
    return 1;
}

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

// ---------------------------------------------------------------- levels

const char *level_name(int level)
{
    const duet_level_info *info = duet_level_get_info((duet_level)level);
    return info ? info->name : NULL;
}

static const member accuracy_members[] = {
    MEMBERS(duet_accuracy, missed, false_rate),
    {0},
};

// Members that the table leaves out are 0.
static void read_accuracy(lua_State *L, const member *m, void *at)
{
    *(duet_accuracy *)at = (duet_accuracy){0};
    member_read_struct(L, m, at);
}

const member_type member_accuracy = {read_accuracy, member_push_struct, accuracy_members,
                                     "an accuracy"};

duet_level level_check(lua_State *L, int index)
{
    duet_level level = DUET_LEVEL_CERTIFIED;
    const char *name = luaL_checkstring(L, index);
    if (!duet_level_from_name(name, &level))
        luaL_argerror(L, index,
                      lua_pushfstring(L, "there is no level '%s'; duet.levels() lists them", name));
    return level;
}

// One table a level, the default first.
static int list_levels(lua_State *L)
{
    lua_newtable(L);
    for (int level = 0; level_name(level); ++level) {
        member_push_table(L, MEMBERS_OF(duet_level_info, name, about, missed, added),
                          duet_level_get_info((duet_level)level));
        lua_rawseti(L, -2, level + 1);
    }
    return 1;
}

static int level_covers(lua_State *L)
{
    lua_pushboolean(L, duet_level_covers(level_check(L, 1), level_check(L, 2)));
    return 1;
}

const lua_noun plan_noun = {{NULL},
                            (const lua_method[]){{"duet.modes", modes, 0},
                                                 {"duet.levels", list_levels, 0},
                                                 {"duet.level_covers", level_covers, 0},
                                                 {0}}};
