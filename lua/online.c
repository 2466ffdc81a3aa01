// SPDX-License-Identifier: MIT
// world:online, motion:online and task:online: keep a plan near its best while frames go by.
#include "lua/motion.h"
#include "lua/policy.h"
#include "lua/tune.h"
#include "runtime/broadphase/variant.h"

typedef enum followed { WORLD, MOTION, TASK } followed;

// The uservalue is the world, motion or task that is followed.
typedef struct online_box {
    duet_online *online;
    followed kind;
    world_box *world; // the uservalue's, if that is a world
} online_box;

static const lua_class online_class = {
    .name = "duet.online",
};

// A script's form of the def; the rest of the C def follows from it.
typedef struct online_def {
    duet_online_def def;
    field_name_list variants;
    field_enum_list modes;
} online_def;

static const field online_fields[] = {
    FIELDS_IN(online_def, def., most_extra, keep, store),
    FIELDS(online_def, variants),
    FIELD_ENUMS(online_def, modes, mode_to_search_name),
    {0},
};

// A motion and a task have nothing but their share to move.
static const field share_fields[] = {
    FIELDS_IN(online_def, def., most_extra),
    {0},
};

static online_box *check_online(lua_State *L)
{
    online_box *box = luaL_checkudata(L, 1, online_class.name);
    luaL_argcheck(L, box->online, 1, "the online plan is closed");
    return box;
}

// Checks that it follows such a thing, which is pushed.
static online_box *check_follows(lua_State *L, followed kind)
{
    static const char *const names[][2] = {
        {"world", "step"}, {"motion", "advance"}, {"task", "run"}};
    online_box *box = check_online(L);
    if (box->kind != kind)
        luaL_argerror(L, 1,
                      lua_pushfstring(L, "it follows a %s: expected online:%s()",
                                      names[box->kind][0], names[box->kind][1]));
    lua_getiuservalue(L, 1, 1);
    return box;
}

// world:online(def)
static int world_online(lua_State *L)
{
    duet_error err = {0};
    world_box *world = world_check(L);
    duet_mode modes[FIELD_NAMES];
    online_def o = {.def = duet_default_online_def()};
    field_read(L, 2, "an online plan", online_fields, &o);
    if (o.def.keep)
        policy_check_trusted(L, "keeping a profile (or else keep = false)");
    o.def.world = world->world;
    o.def.variants = o.variants.names;
    o.def.n_variants = o.variants.n;
    o.def.n_modes = tune_take_modes(&o.modes, modes);
    o.def.modes = modes;
    online_box *box = class_push_of(L, &online_class, sizeof *box, 1);
    ++world->steps; // create steps the world
    world_forget_views(world);
    box->online = duet_online_create(&o.def, &err);
    if (!box->online)
        return class_push_failure(L, &err);
    box->world = world;
    ++world->onlines;
    return 1;
}

static int follow_share(lua_State *L, followed kind, online_def *o)
{
    duet_error err = {0};
    field_read(L, 2, "an online plan", share_fields, o);
    online_box *box = class_push_of(L, &online_class, sizeof *box, 1);
    box->kind = kind;
    box->online = duet_online_create(&o->def, &err);
    return box->online ? 1 : class_push_failure(L, &err);
}

// motion:online(def)
static int motion_online(lua_State *L)
{
    online_def o = {.def = duet_default_online_def()};
    o.def.motion = motion_check_box(L, 1)->motion;
    return follow_share(L, MOTION, &o);
}

// task:online(def)
static int task_online(lua_State *L)
{
    online_def o = {.def = duet_default_online_def()};
    o.def.task = task_check_lua(L, 1);
    return follow_share(L, TASK, &o);
}

static int online_step(lua_State *L)
{
    duet_error err = {0};
    duet_result result = {0};
    lua_settop(L, 1);
    online_box *box = check_follows(L, WORLD);
    ++box->world->steps;
    world_forget_views(box->world);
    if (!duet_online_step(box->online, &result, &err))
        return class_push_failure(L, &err);
    result_push(L, 2, &result);
    return 1;
}

static bool advance_online(void *by, duet_motion *motion, duet_motion_result *result,
                           duet_error *err)
{
    (void)motion;
    return duet_online_advance(by, result, err);
}

static int online_advance(lua_State *L)
{
    online_box *box = check_follows(L, MOTION);
    return motion_run_by(L, lua_gettop(L), advance_online, box->online);
}

static int online_run(lua_State *L)
{
    duet_error err = {0};
    duet_task_result result;
    online_box *box = check_follows(L, TASK);
    task_check_lua(L, -1); // that is open
    class_check_limits(L);
    if (!duet_online_run(box->online, &result, &err))
        return class_push_failure(L, &err);
    return task_result_push(L, &result);
}

static int online_tunings(lua_State *L)
{
    lua_pushinteger(L, duet_online_get_tunings(check_online(L)->online));
    return 1;
}

// Keeps what was learned if nothing did before, which can fail.
static int online_close(lua_State *L)
{
    duet_error err = {0};
    online_box *box = luaL_checkudata(L, 1, online_class.name);
    if (!box->online)
        return class_push_done(L, true, &err);
    bool ok = duet_online_destroy(box->online, &err);
    box->online = NULL;
    if (box->world)
        --box->world->onlines;
    return class_push_done(L, ok, &err);
}

const lua_noun online_noun = {
    {&online_class},
    (const lua_method[]){METHODS(world, online),
                         METHODS(motion, online),
                         METHODS(task, online),
                         METHODS(online, step, advance, run, tunings, close),
                         {0}}};
