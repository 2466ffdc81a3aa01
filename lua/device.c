// SPDX-License-Identifier: MIT
// duet.devices: what OpenCL offers here; duet.device_pair: two devices that share
// the work.
#include "lua/nouns.h"
#include "lua/policy.h"

static const char *kind_name(int value)
{
    static const char *const names[] = {"CPU", "GPU", "accelerator"};
    return value < 3 ? names[value] : NULL;
}

static const field device_fields[] = {
    FIELDS(duet_device_info, selector, platform, platform_version, name, vendor, driver,
           cl_version),
    FIELD_ENUM(duet_device_info, kind, kind_name),
    FIELDS(duet_device_info, units, clock_mhz, max_group, global_bytes, local_bytes,
           max_buffer_bytes, host_memory, fp64, can_cut),
    {0},
};

static void push_device(lua_State *L, const duet_device_info *info)
{
    const char *quirk;
    field_push_table(L, device_fields, info);
    lua_newtable(L);
    for (uint32_t i = 0; (quirk = duet_device_info_get_quirk(info, i)); ++i) {
        lua_pushstring(L, quirk);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "quirks");
}

CLASS_DESTROY(device_list)

// Its userdata is only there to be collected where an error is raised.
static const lua_class list_class = {.name = "duet.device_list", .destroy = destroy_device_list};

static int devices(lua_State *L)
{
    duet_error err = {0};
    lua_handle *list = class_push(L, &list_class, sizeof *list);
    list->object = duet_device_list_create(&err);
    if (!list->object)
        return class_push_failure(L, &err);
    lua_newtable(L);
    for (uint32_t i = 0; i < duet_device_list_get_count(list->object); ++i) {
        push_device(L, duet_device_list_get_info(list->object, i));
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_newtable(L);
    const char *why;
    for (uint32_t i = 0; (why = duet_device_list_get_absent(list->object, i)); ++i) {
        lua_pushstring(L, why);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "absent");
    return 1;
}

// ---------------------------------------------------------------- pairs

static int pair_about(lua_State *L);

// Objects that were made on the pair hold it open.
CLASS_DESTROY(device_pair)

static const lua_class pair_class = {.name = "duet.device_pair",
                                     .about = pair_about,
                                     .destroy = destroy_device_pair,
                                     .noun = "device pair"};

duet_device_pair *device_pair_check(lua_State *L)
{
    return class_object(L, 1, &pair_class);
}

// By a def, or by a string as --pair takes it.
static int pair_open(lua_State *L)
{
    duet_error err = {0};
    duet_device_pair_def def = duet_default_device_pair_def();
    const char *const kernel_dir = def.kernel_dir;
    const char *const cache_dir = def.cache_dir;
    if (lua_type(L, 1) == LUA_TSTRING)
        def.a = text_check(L, 1);
    else
        field_read(L, 1, "a device pair",
                   FIELD_LIST(duet_device_pair_def, a, b, kernel_dir, cache_dir), &def);
    if (def.kernel_dir != kernel_dir || def.cache_dir != cache_dir)
        policy_check_trusted(L, "choosing kernel_dir or cache_dir");
    lua_handle *pair = class_push(L, &pair_class, sizeof *pair);
    pair->object = duet_device_pair_create(&def, &err);
    return pair->object ? 1 : class_push_failure(L, &err);
}

// "A" or "B"
static int device_pair_device(lua_State *L)
{
    static const char *const names[] = {"A", "B", NULL};
    const duet_device_pair *pair = device_pair_check(L);
    int device = luaL_checkoption(L, 2, NULL, names);
    push_device(L, duet_device_pair_get_info(pair, device));
    return 1;
}

static int pair_about(lua_State *L)
{
    const duet_device_pair *pair = device_pair_check(L);
    const duet_device_info *a = duet_device_pair_get_info(pair, 0);
    const duet_device_info *b = duet_device_pair_get_info(pair, 1);
    if (duet_device_pair_is_one(pair))
        lua_pushfstring(L, "A = B = %s %s", a->selector, a->name);
    else
        lua_pushfstring(L, "A = %s %s, B = %s %s", a->selector, a->name, b->selector, b->name);
    return 1;
}

static int device_pair_plan(lua_State *L)
{
    duet_plan plan = duet_default_plan(device_pair_check(L));
    return plan_push(L, &plan);
}

static int device_pair_check_cache(lua_State *L)
{
    duet_error err = {0};
    bool ok = duet_device_pair_check_cache(device_pair_check(L), &err);
    return class_push_done(L, ok, &err);
}

const lua_noun device_noun = {{&list_class, &pair_class},
                              (const lua_method[]){{"duet.devices", devices, 0},
                                                   {"duet.device_pair", pair_open, 0},
                                                   METHODS(device_pair, device, plan, check_cache),
                                                   {0}}};
