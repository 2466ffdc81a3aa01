// SPDX-License-Identifier: MIT
// duet.cluster: objects divided among the ranks of an MPI job. Every rank runs the script.
//
// Closing is collective, so no collector may do it at a time of its own: the registry holds every
// cluster until it is closed, or until the state is, which closes the last one first.
#include "base/error.h"
#include "cluster/duet_cluster.h"
#include "lua/motion_commands.h"
#include "lua/nouns.h"
#include "lua/policy.h"

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

// ---------------------------------------------------------------- the library

// The calls of libduet_cluster, which is loaded when a script asks for its first cluster: nothing
// else of this module knows MPI. That library holds all of Duet once more, so no object of ours
// may go into one of its calls: only numbers, texts, and rows.
#define CLUSTER_CALLS(X)                             \
    X(version, duet_version)                         \
    X(default_def, duet_default_cluster_def)         \
    X(create, duet_cluster_create)                   \
    X(destroy, duet_cluster_destroy)                 \
    X(get_rank, duet_cluster_get_rank)               \
    X(get_rank_count, duet_cluster_get_rank_count)   \
    X(load_scene, duet_cluster_load_scene)           \
    X(get_scene_info, duet_cluster_get_scene_info)   \
    X(set_objects, duet_cluster_set_objects)         \
    X(map_owned, duet_cluster_map_owned)             \
    X(set_plan, duet_cluster_set_plan)               \
    X(load_profile, duet_cluster_load_profile)       \
    X(set_level, duet_cluster_set_level)             \
    X(step, duet_cluster_step)                       \
    X(get_own_pairs, duet_cluster_get_own_pairs)     \
    X(get_ranks, duet_cluster_get_ranks)             \
    X(save_pairs, duet_cluster_save_pairs)           \
    X(begin_motion, duet_cluster_begin_motion)       \
    X(get_motion_step, duet_cluster_get_motion_step) \
    X(advance, duet_cluster_advance)                 \
    X(get_state_hash, duet_cluster_get_state_hash)   \
    X(save_motion, duet_cluster_save_motion)         \
    X(get_motion_def, duet_cluster_get_motion_def)   \
    X(get_user_data, duet_cluster_get_user_data)

#define TYPE_OF(member, call) __typeof__(&(call)) member;
#define NAME_OF(member, call) {#call, offsetof(cluster_library, member)},

typedef struct cluster_library {
    CLUSTER_CALLS(TYPE_OF)
#define COMMAND(number, name, form, bodies, effect, type, rows) TYPE_OF(name, duet_cluster_##name)
#include "runtime/commands/commands.inl"
} cluster_library;

static const struct {
    const char *name;
    size_t place;
} call_names[] = {CLUSTER_CALLS(NAME_OF)
#define COMMAND(number, name, form, bodies, effect, type, rows) NAME_OF(name, duet_cluster_##name)
#include "runtime/commands/commands.inl"
};

// All of them, or the name of the first that is not there.
static const char *find_calls(void *library, cluster_library *found)
{
    for (size_t i = 0; i < sizeof call_names / sizeof *call_names; ++i) {
        void *call = dlsym(library, call_names[i].name);
        if (!call)
            return call_names[i].name;
        memcpy((char *)found + call_names[i].place, &call, sizeof call);
    }
    return NULL;
}

// The process's. NULL with NOT_FOUND if there is none, or one of another version.
//
// It stays until the process ends, for MPI may have threads in it. Its own calls bind to itself
// (module.cmake), so that two copies of Duet never share a function.
static const cluster_library *load_library(duet_error *err)
{
    static cluster_library known;
    cluster_library found;
    if (known.version)
        return &known;
    void *library = dlopen(CLUSTER_LIBRARY, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!library)
        return error_null(
            err, DUET_STATUS_NOT_FOUND,
            "%s; on Debian it is in the package duet-cluster, and a Duet that was built "
            "without MPI has none",
            dlerror());
    const char *lacking = find_calls(library, &found);
    if (lacking || strcmp(found.version(), duet_version()) != 0)
        return error_null(err, DUET_STATUS_NOT_FOUND, "%s is of another version%s%s; expected %s",
                          CLUSTER_LIBRARY, lacking ? ", without " : " of Duet, ",
                          lacking ? lacking : found.version(), duet_version());
    known = found;
    return &known;
}

// ---------------------------------------------------------------- what a script sees

typedef struct cluster_box {
    lua_handle cluster;
    const cluster_library *calls;
    int64_t rank, rank_count;
    array_kind rows; // its objects'
    uint64_t maps;   // views of owned objects hold until the next call
    uint64_t steps;  // views of pairs hold until the next step, or other objects
} cluster_box;

static const lua_class cluster_class;

static const field def_fields[] = {
    FIELDS(duet_cluster_def, pair, plain, weight, parts, drops_pairs, imbalance),
    FIELD_IN(field_plan, duet_cluster_def, world., plan),
    FIELDS_IN(duet_cluster_def, world., dims),
    FIELD_ENUM_AT("shape", duet_cluster_def, world.shape, shape_name),
    FIELD_ENUM_AT("level", duet_cluster_def, world.level, level_name),
    FIELDS_IN(duet_cluster_def, world., rotated, cell, cell_fixed, max_pairs),
    {0},
};

static const field box_fields[] = {
    FIELDS(cluster_box, rank, rank_count),
    {0},
};

static cluster_box *check(lua_State *L)
{
    cluster_box *box = class_check(L, 1, &cluster_class);
    ++box->maps;
    return box;
}

static const void *struct_of(lua_State *L)
{
    return class_check(L, 1, &cluster_class);
}

// ---------------------------------------------------------------- making

// In the registry: the clusters that are open.
static const char open_key = 0;

static void hold(lua_State *L, bool held)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &open_key);
    lua_pushvalue(L, -2);
    lua_pushboolean(L, held);
    if (!held) {
        lua_pop(L, 1);
        lua_pushnil(L);
    }
    lua_rawset(L, -3);
    lua_pop(L, 1);
}

// Leaves its userdata on the stack.
static bool push_cluster(lua_State *L, const cluster_library *calls, const duet_cluster_def *def,
                         duet_error *err)
{
    cluster_box *box = class_push(L, &cluster_class, sizeof *box);
    *box = (cluster_box){.calls = calls, .rows = shape_array_kind((int)def->world.shape)};
    hold(L, true);
    box->cluster.object = calls->create(def, err);
    box->rank = calls->get_rank(box->cluster.object);
    box->rank_count = calls->get_rank_count(box->cluster.object);
    if (!box->cluster.object)
        hold(L, false);
    return box->cluster.object;
}

// A process begins MPI once. An empty cluster holds it for those that come one after the other,
// and is the last to be closed.
static bool begin_mpi(lua_State *L, const cluster_library *calls, duet_error *err)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &open_key) == LUA_TTABLE) {
        lua_pop(L, 1);
        return true;
    }
    lua_pop(L, 1);
    lua_newtable(L);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &open_key);
    duet_cluster_def none = calls->default_def();
    none.plain = true;
    bool ok = push_cluster(L, calls, &none, err);
    lua_pop(L, 1);
    if (!ok) {
        lua_pushnil(L);
        lua_rawsetp(L, LUA_REGISTRYINDEX, &open_key);
    }
    return ok;
}

// duet.cluster(def)
static int create(lua_State *L)
{
    duet_error err = {0};
    policy_check_trusted(L, "duet.cluster");
    const cluster_library *calls = load_library(&err);
    if (!calls)
        return class_push_failure(L, &err);
    lua_settop(L, 1);
    duet_cluster_def def = calls->default_def();
    field_read(L, 1, "a cluster", def_fields, &def);
    if (!begin_mpi(L, calls, &err) || !push_cluster(L, calls, &def, &err))
        return class_push_failure(L, &err);
    return 1;
}

static int cluster_close(lua_State *L)
{
    cluster_box *box = luaL_checkudata(L, 1, cluster_class.name);
    if (!box->cluster.object)
        return 0;
    box->calls->destroy(box->cluster.object);
    box->cluster.object = NULL;
    ++box->maps;
    ++box->steps;
    lua_settop(L, 1);
    hold(L, false);
    return 0;
}

// ---------------------------------------------------------------- objects

static int cluster_load_scene(lua_State *L)
{
    duet_error err = {0};
    uint32_t n = 0;
    cluster_box *box = check(L);
    const char *path = text_check(L, 2);
    const duet_setting *settings = scene_read_settings(L, 3, &n);
    ++box->steps;
    if (!box->calls->load_scene(box->cluster.object, path, settings, n, &err))
        return class_push_failure(L, &err);
    const duet_scene_info *info = box->calls->get_scene_info(box->cluster.object);
    box->rows = shape_array_kind(info->origin_edge > 0 ? TREE_LARGE_POSES : (int)info->shape);
    scene_push_info(L, info);
    return 1;
}

static int cluster_scene(lua_State *L)
{
    cluster_box *box = check(L);
    const duet_scene_info *info = box->calls->get_scene_info(box->cluster.object);
    if (info)
        scene_push_info(L, info);
    else
        lua_pushnil(L);
    return 1;
}

// cluster:set_objects(ids, rows)
static int cluster_set_objects(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    lua_settop(L, 3);
    const array *ids = array_check(L, 2, ARRAY_IDS);
    const array *rows = array_check(L, 3, box->rows);
    luaL_argcheck(L, ids->n == rows->n, 3, "as many objects as there are ids");
    luaL_argcheck(L, ids->n <= DUET_MOST_OBJECTS, 2, "more than 2^32 - 3 objects");
    ++box->steps;
    bool ok = box->calls->set_objects(box->cluster.object, array_object_kind(box->rows), ids->rows,
                                      rows->rows, (uint32_t)ids->n, &err);
    return class_push_done(L, ok, &err);
}

// cluster:map_owned() -> rows, ids
static int cluster_map_owned(lua_State *L)
{
    duet_error err = {0};
    const uint64_t *ids = NULL;
    uint32_t n = 0;
    cluster_box *box = check(L);
    void *owned =
        box->calls->map_owned(box->cluster.object, array_object_kind(box->rows), &ids, &n, &err);
    if (!owned)
        return class_push_failure(L, &err);
    array_push_view(L, box->rows, ARRAY_OPEN, owned, n, &box->maps);
    array_push_view(L, ARRAY_IDS, ARRAY_FIXED, (void *)ids, n, &box->maps);
    return 2;
}

// ---------------------------------------------------------------- stepping

static int cluster_set_plan(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    duet_plan plan = duet_default_plan(NULL);
    plan_read(L, &plan);
    return class_push_done(L, box->calls->set_plan(box->cluster.object, &plan, &err), &err);
}

static int cluster_set_level(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    duet_level level = level_check(L, 2);
    return class_push_done(L, box->calls->set_level(box->cluster.object, level, &err), &err);
}

// cluster:load_profile(path) -> profile, and the line of a store that cannot be read
static int cluster_load_profile(lua_State *L)
{
    duet_error err = {0}, store_failed = {0};
    duet_profile profile;
    cluster_box *box = check(L);
    const char *path = text_option(L, 2);
    if (!box->calls->load_profile(box->cluster.object, path, &profile, &store_failed, &err))
        return class_push_failure(L, &err);
    profile_push_known(L, &profile);
    if (store_failed.status == DUET_STATUS_OK)
        return 1;
    lua_pushstring(L, store_failed.text);
    return 2;
}

static int cluster_step(lua_State *L)
{
    duet_error err = {0};
    duet_cluster_result result = {0};
    cluster_box *box = check(L);
    ++box->steps;
    if (!box->calls->step(box->cluster.object, &result, &err))
        return class_push_failure(L, &err);
    field_push_table(L, FIELD_LIST(duet_cluster_result, objects, pairs, total_ms), &result);
    array_push_hash(L, result.hash);
    lua_setfield(L, -2, "hash");
    return 1;
}

static int cluster_own_pairs(lua_State *L)
{
    duet_error err = {0};
    const duet_pair64 *pairs = NULL;
    uint64_t n = 0;
    cluster_box *box = check(L);
    if (!box->calls->get_own_pairs(box->cluster.object, &pairs, &n, &err))
        return class_push_failure(L, &err);
    array_push_view(L, ARRAY_PAIRS64, ARRAY_FIXED, (void *)pairs, n, &box->steps);
    return 1;
}

static int cluster_ranks(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    duet_cluster_rank *ranks = lua_newuserdatauv(L, (size_t)box->rank_count * sizeof *ranks, 0);
    if (!box->calls->get_ranks(box->cluster.object, ranks, &err))
        return class_push_failure(L, &err);
    field_push_list(L,
                    FIELD_LIST(duet_cluster_rank, host, pair, objects, ghosts, pairs, sent_bytes,
                               busy_ms, wait_ms),
                    ranks, (uint64_t)box->rank_count, sizeof *ranks);
    return 1;
}

// cluster:save_pairs(path, sorted)
static int cluster_save_pairs(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    const char *path = text_check(L, 2);
    bool ok = box->calls->save_pairs(box->cluster.object, path, lua_toboolean(L, 3), &err);
    return class_push_done(L, ok, &err);
}

// ---------------------------------------------------------------- motion

// cluster:begin_motion(path, settings, resume)
static int cluster_begin_motion(lua_State *L)
{
    duet_error err = {0};
    uint32_t n = 0;
    cluster_box *box = check(L);
    const char *path = text_check(L, 2);
    const char *resume = text_option(L, 4); // before settings, which come onto the stack
    const duet_setting *settings = scene_read_settings(L, 3, &n);
    bool ok = box->calls->begin_motion(box->cluster.object, path, settings, n, resume, &err);
    return class_push_done(L, ok, &err);
}

static int cluster_motion_step(lua_State *L)
{
    cluster_box *box = check(L);
    lua_pushinteger(L, (lua_Integer)box->calls->get_motion_step(box->cluster.object));
    return 1;
}

static int cluster_advance(lua_State *L)
{
    duet_error err = {0};
    duet_cluster_motion_result result = {0};
    cluster_box *box = check(L);
    if (!box->calls->advance(box->cluster.object, &result, &err))
        return class_push_failure(L, &err);
    field_push_table(L,
                     FIELD_LIST(duet_cluster_motion_result, step, bodies, ghosts, contacts, colours,
                                total_ms, slowest_ms, mean_ms, slowest_rank),
                     &result);
    field_push_list(L, FIELD_LIST(duet_event, a, b, begins), result.events, result.n_events,
                    sizeof *result.events);
    lua_setfield(L, -2, "events");
    field_push_list(L, FIELD_LIST(duet_pair, a, b), result.stays, result.n_stays,
                    sizeof *result.stays);
    lua_setfield(L, -2, "stays");
    field_push_list(L, FIELD_LIST(duet_hit_event, a, b, point, normal, speed, impulse), result.hits,
                    result.n_hits, sizeof *result.hits);
    lua_setfield(L, -2, "hits");
    return 1;
}

static int cluster_state_hash(lua_State *L)
{
    duet_error err = {0};
    uint64_t hash = 0;
    cluster_box *box = check(L);
    if (!box->calls->get_state_hash(box->cluster.object, &hash, &err))
        return class_push_failure(L, &err);
    array_push_hash(L, hash);
    return 1;
}

static int cluster_save_motion(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    const char *path = text_check(L, 2);
    return class_push_done(L, box->calls->save_motion(box->cluster.object, path, &err), &err);
}

// ---------------------------------------------------------------- commands

#define SEND_LIST(name) l->name(c, k->list, err)
#define SEND_ROWS(name) l->name(c, k->list, k->rows, err)
#define SEND_FIELDS(name) l->name(c, k->list, k->fields, k->rows, err)
#define SEND_ADD(name) l->name(c, k->rows, k->new_bodies, k->list.n, k->new_ids, err)
#define SEND_DEF(name) l->name(c, k->rows, err)

static bool send(const cluster_library *l, duet_cluster *c, const command *k, duet_error *err)
{
    switch (k->op->number) {
#define COMMAND(number, name, form, bodies, effect, type, rows) \
    case number:                                                \
        return SEND_##form(name);
#include "runtime/commands/commands.inl"
    default:
        return false;
    }
}

static int cluster_command(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    const duet_motion_def *moving = box->calls->get_motion_def(box->cluster.object);
    duet_motion_def def = moving ? *moving : (duet_motion_def){0};
    const command c = command_read_lua(L, &def);
    return command_push_lua(L, &c, send(box->calls, box->cluster.object, &c, &err), &err);
}

// cluster:user_data(list)
static int cluster_user_data(lua_State *L)
{
    duet_error err = {0};
    cluster_box *box = check(L);
    duet_body_list list = command_check_list_lua(L);
    array *data = array_push(L, ARRAY_IDS, list.n);
    return box->calls->get_user_data(box->cluster.object, list, data->rows, &err)
               ? 1
               : class_push_failure(L, &err);
}

static const lua_class cluster_class = {
    .name = "duet.cluster", .fields = box_fields, .struct_of = struct_of, .noun = "cluster"};

const lua_noun cluster_noun = {
    {&cluster_class},
    (const lua_method[]){{"duet.cluster", create, 0},

#define COMMAND(number, name, form, bodies, effect, type, rows) \
    {"duet.cluster:" #name, cluster_command, number},
#include "runtime/commands/commands.inl"

                         METHODS(cluster, close, load_scene, scene, set_objects, map_owned,
                                 set_plan, set_level, load_profile, step, own_pairs, ranks,
                                 save_pairs, begin_motion, motion_step, advance, state_hash),
                         METHODS(cluster, save_motion, user_data),
                         {0}}};
