// SPDX-License-Identifier: MIT
// world:online: keeps a world's share near its best while frames go by.
#include "lua/nouns.h"
#include "lua/policy.h"

#include "duet_tune.h"

typedef struct online_box {
    duet_online *online;
    world_box *world; // the uservalue's
} online_box;

static const lua_class online_class;

static const member def_members[] = {
    MEMBER(member_double, duet_online_def, most_extra),
    MEMBER(member_bool, duet_online_def, keep),
    MEMBER(member_string, duet_online_def, store),
    {0},
};

static online_box *check_online(lua_State *L)
{
    online_box *box = luaL_checkudata(L, 1, online_class.name);
    luaL_argcheck(L, box->online, 1, "the online share is closed");
    return box;
}

int world_online_lua(lua_State *L)
{
    duet_error err = {0};
    world_box *world = world_check(L, 1);
    duet_online_def def = duet_default_online_def();
    member_read_table(L, 2, "an online share", def_members, &def);
    if (def.keep)
        policy_check_trusted(L, "keeping a profile (or else keep = false)");
    def.world = world->world;
    online_box *box = class_push(L, &online_class, sizeof *box);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    box->online = duet_online_create(&def, &err);
    if (!box->online)
        return class_push_failure(L, &err);
    box->world = world;
    ++world->onlines;
    return 1;
}

static int online_step(lua_State *L)
{
    duet_error err = {0};
    duet_result result = {0};
    online_box *box = check_online(L);
    ++box->world->steps;
    world_forget_views(box->world);
    if (!duet_online_step(box->online, &result, &err))
        return class_push_failure(L, &err);
    lua_getiuservalue(L, 1, 1);
    result_push(L, -1, &result);
    return 1;
}

static int online_tunings(lua_State *L)
{
    lua_pushinteger(L, duet_online_get_tunings(check_online(L)->online));
    return 1;
}

// What was learned may be kept only here, and that can fail.
static int online_close(lua_State *L)
{
    duet_error err = {0};
    online_box *box = luaL_checkudata(L, 1, online_class.name);
    if (!box->online)
        return class_push_done(L, true, &err);
    bool ok = duet_online_destroy(box->online, &err);
    box->online = NULL;
    --box->world->onlines;
    return class_push_done(L, ok, &err);
}

static const luaL_Reg methods[] = {
    {"step", online_step}, {"tunings", online_tunings}, {"close", online_close}, {NULL, NULL}};
static const lua_class online_class = {.name = "duet.online", .methods = methods};

void online_open_lua(lua_State *L)
{
    class_open(L, &online_class);
}
