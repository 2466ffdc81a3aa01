// SPDX-License-Identifier: MIT
// duet.device_pair: two devices that share the work.
#include "lua/nouns.h"
#include "lua/policy.h"

static int pair_close(lua_State *L);
static int pair_device(lua_State *L);
static int pair_plan(lua_State *L);

static const luaL_Reg methods[] = {{"close", pair_close},         {"device", pair_device},
                                   {"plan", pair_plan},           {"tune", device_pair_tune_lua},
                                   {"motion", motion_create_lua}, {"query", pair_query_create_lua},
                                   {"world", world_create_lua},   {NULL, NULL}};
static const lua_class pair_class = {.name = "duet.device_pair", .methods = methods};

static const member def_members[] = {
    MEMBER(member_string, duet_device_pair_def, a),
    MEMBER(member_string, duet_device_pair_def, b),
    MEMBER(member_string, duet_device_pair_def, kernel_dir),
    MEMBER(member_string, duet_device_pair_def, cache_dir),
    {0},
};

typedef struct device_pair_box {
    duet_device_pair *pair; // NULL: closed
} device_pair_box;

duet_device_pair *device_pair_check(lua_State *L, int index)
{
    device_pair_box *box = luaL_checkudata(L, index, pair_class.name);
    luaL_argcheck(L, box->pair, index, "the device pair is closed");
    return box->pair;
}

// What was made on the pair holds it open.
static int pair_close(lua_State *L)
{
    device_pair_box *box = luaL_checkudata(L, 1, pair_class.name);
    duet_device_pair_destroy(box->pair);
    box->pair = NULL;
    return 0;
}

static int pair_open(lua_State *L)
{
    duet_error err = {0};
    duet_device_pair_def def = duet_default_device_pair_def();
    const char *const kernel_dir = def.kernel_dir;
    const char *const cache_dir = def.cache_dir;
    member_read_table(L, 1, "a device pair", def_members, &def);
    if (def.kernel_dir != kernel_dir || def.cache_dir != cache_dir)
        policy_check_trusted(L, "choosing kernel_dir or cache_dir");
    device_pair_box *box = class_push(L, &pair_class, sizeof *box);
    box->pair = duet_device_pair_create(&def, &err);
    return box->pair ? 1 : class_push_failure(L, &err);
}

// "A" or "B"
static int pair_device(lua_State *L)
{
    static const char *const names[] = {"A", "B", NULL};
    const duet_device_pair *pair = device_pair_check(L, 1);
    int device = luaL_checkoption(L, 2, NULL, names);
    member_push_table(L, device_members, duet_device_pair_get_info(pair, device));
    return 1;
}

static int pair_plan(lua_State *L)
{
    duet_plan plan = duet_default_plan(device_pair_check(L, 1));
    member_plan.push(L, NULL, &plan);
    return 1;
}

void device_pair_open_lua(lua_State *L)
{
    static const luaL_Reg functions[] = {{"device_pair", pair_open}, {NULL, NULL}};
    class_open(L, &pair_class);
    luaL_setfuncs(L, functions, 0);
}
