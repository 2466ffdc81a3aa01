// SPDX-License-Identifier: MIT
// How a step is done: plans, { share = 0.25, mode = "own", variant_a = ..., variant_b = ... },
// and levels of accuracy, by their names.
#include "lua/nouns.h"
#include "runtime/broadphase/variant.h"

#include <math.h>

static void read_share(lua_State *L, const field *f, void *at)
{
    lua_Number share = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : -1;
    if (!(share >= 0 && share <= 1))
        field_refuse(L, f, "a part from 0 to 1");
    *(uint32_t *)at = (uint32_t)lround(share * DUET_SHARE_ONE);
}

static void push_share(lua_State *L, const field *f, const void *at)
{
    (void)f;
    lua_pushnumber(L, (lua_Number) * (const uint32_t *)at / DUET_SHARE_ONE);
}

const field_type field_share = {.read = read_share, .push = push_share};

static const field plan_fields[] = {
    FIELD(field_share, duet_plan, share),
    FIELD_ENUM(duet_plan, mode, mode_name),
    FIELDS(duet_plan, variant_a, variant_b),
    {0},
};

const field_type field_plan = {field_read_struct, field_push_struct, plan_fields, "a plan"};

void plan_read(lua_State *L, duet_plan *plan)
{
    static const field argument = {.name = "plan", .type = &field_plan};
    lua_settop(L, 2);
    field_read_struct(L, &argument, plan);
}

int plan_push(lua_State *L, const duet_plan *plan)
{
    if (plan)
        field_push_table(L, plan_fields, plan);
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

duet_level level_check(lua_State *L, int index)
{
    duet_level level = DUET_LEVEL_CERTIFIED;
    const char *name = text_check(L, index);
    if (!duet_level_from_name(name, &level))
        luaL_argerror(L, index,
                      lua_pushfstring(L, "level is '%s'; expected one of %s",
                                      field_push_shown(L, index), field_push_names(L, level_name)));
    return level;
}

// One table a level, the default first.
static int list_levels(lua_State *L)
{
    lua_newtable(L);
    for (int level = 0; level_name(level); ++level) {
        field_push_table(L, FIELD_LIST(duet_level_info, name, about, missed, added),
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
