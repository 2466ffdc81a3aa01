// SPDX-License-Identifier: MIT
// What is in a store of profiles: duet.profiles and what goes with it;
// world:load_profile, the plan that is known for a world's objects.
#include "lua/nouns.h"
#include "lua/policy.h"
#include "profiles/duet_profiles.h"

static const field device_parts[] = {
    FIELDS(duet_stored_device, name, part, driver),
    {0},
};

static const field_type field_device = {.push = field_push_struct, .fields = device_parts};

static const field profile_fields[] = {
#define STORED_PROFILE
#define COLUMN(type, member, value) FIELD(field_##type, duet_stored_profile, member),
#define DEVICE(member, name, part, driver) FIELD(field_device, duet_stored_profile, member),
#include "profiles/stored.inl"
    {0},
};

static const field trial_fields[] = {
#define STORED_TRIAL
#define COLUMN(type, member, value) FIELD(field_##type, duet_stored_trial, member),
#include "profiles/stored.inl"
    {0},
};

// A store to read; nil is the user's.
static const char *check_store(lua_State *L, int index)
{
    const char *path = text_option(L, index);
    if (path)
        policy_check_read(L, path);
    return path;
}

// These userdata are only there to be collected where an error is raised.
CLASS_DESTROY(profile_list)

static const lua_class list_class = {.name = "duet.profile_list", .destroy = destroy_profile_list};
static const lua_class memory_class = {.name = "duet.memory", .destroy = duet_free};

// duet.profiles(path, replaced_too)
static int profiles(lua_State *L)
{
    duet_error err = {0};
    const char *path = check_store(L, 1);
    bool replaced_too = lua_toboolean(L, 2);
    lua_handle *list = class_push(L, &list_class, sizeof *list);
    list->object = duet_profile_list_create(path, replaced_too, &err);
    if (!list->object)
        return class_push_failure(L, &err);
    lua_newtable(L);
    for (uint32_t i = 0; i < duet_profile_list_get_count(list->object); ++i) {
        field_push_table(L, profile_fields, duet_profile_list_get_profile(list->object, i));
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

// duet.profile_trials(uid, path)
static int profile_trials(lua_State *L)
{
    duet_error err = {0};
    duet_stored_trial *trials = NULL;
    uint32_t n = 0;
    const char *uid = text_check(L, 1);
    const char *path = check_store(L, 2);
    lua_handle *memory = class_push(L, &memory_class, sizeof *memory);
    if (!duet_profile_get_trials(path, uid, &trials, &n, &err))
        return class_push_failure(L, &err);
    memory->object = trials;
    field_push_list(L, trial_fields, trials, n, sizeof *trials);
    return 1;
}

typedef bool profile_change(const char *path, const char *uid, duet_error *err);

static int change_profile(lua_State *L, profile_change *change, const char *what)
{
    duet_error err = {0};
    const char *uid = text_check(L, 1);
    const char *path = text_option(L, 2);
    policy_check_trusted(L, what);
    return class_push_done(L, change(path, uid, &err), &err);
}

// duet.use_profile(uid, path)
static int use_profile(lua_State *L)
{
    return change_profile(L, duet_profile_use, "duet.use_profile");
}

// duet.forget_profile(uid, path)
static int forget_profile(lua_State *L)
{
    return change_profile(L, duet_profile_forget, "duet.forget_profile");
}

// duet.export_profiles(file, path)
static int export_profiles(lua_State *L)
{
    duet_error err = {0};
    const char *file = text_check(L, 1);
    const char *path = text_option(L, 2);
    policy_check_trusted(L, "duet.export_profiles");
    return class_push_done(L, duet_profiles_export(path, file, &err), &err);
}

// duet.import_profiles(file, path) -> added, known
static int import_profiles(lua_State *L)
{
    duet_error err = {0};
    duet_import_counts counts = {0};
    const char *file = text_check(L, 1);
    const char *path = text_option(L, 2);
    policy_check_trusted(L, "duet.import_profiles");
    if (!duet_profiles_import(path, file, &counts, &err))
        return class_push_failure(L, &err);
    lua_pushinteger(L, (lua_Integer)counts.added);
    lua_pushinteger(L, (lua_Integer)counts.known);
    return 2;
}

// ---------------------------------------------------------------- of a world

static const char *grade_name(int grade)
{
    return duet_grade_name((duet_grade)grade);
}

static const field known_fields[] = {
    FIELD_ENUM(duet_profile, grade, grade_name),
    FIELD(field_plan, duet_profile, plan),
    FIELD_ENUM(duet_profile, level, level_name),
    FIELD(field_accuracy, duet_profile, accuracy),
    FIELDS(duet_profile, true_pairs, step_ms, gain, gain_low, gain_high, verdict, measured_s),
    {0},
};

void profile_push_known(lua_State *L, const duet_profile *profile)
{
    field_push_table(L, known_fields, profile);
}

static int push_loaded(lua_State *L, bool ok, const duet_profile *profile, const duet_error *err)
{
    if (!ok)
        return class_push_failure(L, err);
    profile_push_known(L, profile);
    return 1;
}

// world:load_profile(path), and the same of a motion and of a task.
#define LOAD_PROFILE(what, type, object)                               \
    static int what##_load_profile(lua_State *L)                       \
    {                                                                  \
        duet_error err = {0};                                          \
        duet_profile profile;                                          \
        type *o = object;                                              \
        const char *path = check_store(L, 2);                          \
        bool ok = duet_##what##_load_profile(o, path, &profile, &err); \
        return push_loaded(L, ok, &profile, &err);                     \
    }
LOAD_PROFILE(world, duet_world, world_check(L)->world)
LOAD_PROFILE(motion, duet_motion, motion_check_lua(L))
LOAD_PROFILE(task, duet_task, task_check_lua(L, 1))

// tree:load_profile(query, n, path)
static int tree_load_profile(lua_State *L)
{
    duet_error err = {0};
    duet_profile profile;
    duet_tree *tree = tree_check(L);
    const char *query = text_check(L, 2);
    lua_Integer n = luaL_checkinteger(L, 3);
    luaL_argcheck(L, n > 0, 3, "a number of items above 0");
    const char *path = check_store(L, 4);
    bool ok = duet_tree_load_profile(tree, query, (uint64_t)n, path, &profile, &err);
    return push_loaded(L, ok, &profile, &err);
}

// world:explain_profile(path)
static int world_explain_profile(lua_State *L)
{
    duet_error err = {0};
    char *why = NULL;
    world_box *box = world_check(L);
    const char *path = check_store(L, 2);
    lua_handle *memory = class_push(L, &memory_class, sizeof *memory);
    if (!duet_world_explain_profile(box->world, path, &why, &err))
        return class_push_failure(L, &err);
    memory->object = why;
    lua_pushstring(L, why);
    return 1;
}

const lua_noun profiles_noun = {{&list_class, &memory_class},
                                (const lua_method[]){{"duet.profiles", profiles, 0},
                                                     {"duet.profile_trials", profile_trials, 0},
                                                     {"duet.use_profile", use_profile, 0},
                                                     {"duet.forget_profile", forget_profile, 0},
                                                     {"duet.export_profiles", export_profiles, 0},
                                                     {"duet.import_profiles", import_profiles, 0},
                                                     METHODS(world, load_profile, explain_profile),
                                                     METHODS(task, load_profile),
                                                     METHODS(tree, load_profile),
                                                     METHODS(motion, load_profile),
                                                     {0}}};
