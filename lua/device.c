// SPDX-License-Identifier: MIT
// duet.devices: what OpenCL offers here.
#include "lua/nouns.h"

static const char *kind_name(int value)
{
    static const char *const names[] = {"CPU", "GPU", "accelerator"};
    return value < 3 ? names[value] : NULL;
}

const member device_members[] = {
    MEMBER(member_chars, duet_device_info, selector),
    MEMBER(member_chars, duet_device_info, platform),
    MEMBER(member_chars, duet_device_info, platform_version),
    MEMBER(member_chars, duet_device_info, name),
    MEMBER(member_chars, duet_device_info, vendor),
    MEMBER(member_chars, duet_device_info, driver),
    MEMBER(member_chars, duet_device_info, cl_version),
    MEMBER_ENUM(duet_device_info, kind, kind_name),
    MEMBER(member_count, duet_device_info, units),
    MEMBER(member_count, duet_device_info, clock_mhz),
    MEMBER(member_count, duet_device_info, max_group),
    MEMBER(member_count, duet_device_info, global_bytes),
    MEMBER(member_count, duet_device_info, local_bytes),
    MEMBER(member_count, duet_device_info, max_buffer_bytes),
    MEMBER(member_bool, duet_device_info, host_memory),
    MEMBER(member_bool, duet_device_info, fp64),
    MEMBER(member_bool, duet_device_info, can_cut),
    {0},
};

// The list's userdata is only there to be collected where an error is raised.
static int list_close(lua_State *L)
{
    duet_device_list **list = luaL_checkudata(L, 1, "duet.device_list");
    duet_device_list_destroy(*list);
    *list = NULL;
    return 0;
}

static const luaL_Reg list_methods[] = {{"close", list_close}, {NULL, NULL}};
static const lua_class list_class = {.name = "duet.device_list", .methods = list_methods};

static int devices(lua_State *L)
{
    duet_error err = {0};
    duet_device_list **list = class_push(L, &list_class, sizeof(duet_device_list *));
    *list = duet_device_list_create(&err);
    if (!*list)
        return class_push_failure(L, &err);
    lua_newtable(L);
    for (uint32_t i = 0; i < duet_device_list_get_count(*list); ++i) {
        member_push_table(L, device_members, duet_device_list_get_info(*list, i));
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    duet_device_list_destroy(*list);
    *list = NULL;
    return 1;
}

void device_open_lua(lua_State *L)
{
    static const luaL_Reg functions[] = {{"devices", devices}, {NULL, NULL}};
    class_open(L, &list_class);
    luaL_setfuncs(L, functions, 0);
}
