// SPDX-License-Identifier: MIT
// device_pair:motion: objects that move, and push each other where they touch.
#include "lua/nouns.h"
#include "lua/policy.h"
#include "runtime/scene/scene.h"

#include <string.h>

// The uservalue is its device pair, or { pair, script } if it has a script.
typedef struct motion_box {
    duet_motion *motion;
    uint64_t steps;   // results of earlier ones no longer hold
    uint64_t maps[4]; // so with mapped rows, by part of the state
    bool in_script;
} motion_box;

static const lua_class motion_class;

// ---------------------------------------------------------------- effects

// The effects' names, one bit after the other; NULL past the last.
static const char *effect_at(uint32_t i)
{
    return i < 32 ? duet_effect_name(1u << i) : NULL;
}

static void push_effects(lua_State *L, uint32_t effects)
{
    lua_newtable(L);
    for (uint32_t i = 0; effect_at(i); ++i) {
        if (!(effects & 1u << i))
            continue;
        lua_pushstring(L, effect_at(i));
        lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    }
}

static int list_effects(lua_State *L)
{
    push_effects(L, DUET_EFFECT_ALL);
    return 1;
}

// { "events", "sleep" } -> bits
static void read_effects(lua_State *L, const member *m, void *at)
{
    uint32_t *effects = at;
    if (!lua_istable(L, -1))
        member_refuse(L, m, "a list of effects' names");
    for (lua_Unsigned n = lua_rawlen(L, -1), k = 1; k <= n; ++k) {
        uint32_t i = 0;
        lua_rawgeti(L, -1, (lua_Integer)k);
        const char *name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "?";
        while (effect_at(i) && strcmp(effect_at(i), name) != 0)
            ++i;
        if (!effect_at(i))
            luaL_error(L, "field '%s': there is no effect '%s'; duet.effects() lists them", m->name,
                       name);
        *effects |= 1u << i;
        lua_pop(L, 1);
    }
}

static void push_wants(lua_State *L, const member *m, const void *at)
{
    (void)m;
    push_effects(L, *(const uint32_t *)at);
}

static const member_type member_effects = {read_effects, push_wants};

// ---------------------------------------------------------------- making

static const char *boundary_name(int boundary)
{
    static const char *const names[] = {"none", "walls", "periodic"};
    return boundary < 3 ? names[boundary] : NULL;
}

// script = function(step, motion): kept beside the pair.
static void read_script(lua_State *L, const member *m, void *at)
{
    (void)at;
    if (!lua_isfunction(L, -1))
        member_refuse(L, m, "a function of the step and the motion");
}

static const member_type member_script = {read_script, NULL};

static const member def_members[] = {
    {"script", &member_script, 0, 1, NULL},
    MEMBER(member_plan, duet_motion_def, plan),
    MEMBER(member_count, duet_motion_def, dims),
    MEMBER(member_effects, duet_motion_def, wants),
    MEMBER(member_bool, duet_motion_def, doubles),
    MEMBER(member_double, duet_motion_def, origin),
    MEMBER(member_float, duet_motion_def, origin_edge),
    MEMBER(member_double, duet_motion_def, gravity),
    MEMBER(member_double, duet_motion_def, attraction),
    MEMBER(member_double, duet_motion_def, centre),
    MEMBER(member_double, duet_motion_def, drag),
    MEMBER_ENUM(duet_motion_def, boundary, boundary_name),
    MEMBER(member_double, duet_motion_def, lower),
    MEMBER(member_double, duet_motion_def, upper),
    MEMBER(member_double, duet_motion_def, dt),
    MEMBER(member_count, duet_motion_def, substeps),
    MEMBER_ENUM(duet_motion_def, integrator, scene_integrator_name),
    MEMBER(member_double, duet_motion_def, skin),
    MEMBER(member_double, duet_motion_def, slop),
    MEMBER(member_double, duet_motion_def, max_push_speed),
    MEMBER(member_double, duet_motion_def, restitution_threshold),
    MEMBER(member_double, duet_motion_def, sleep_speed),
    MEMBER(member_double, duet_motion_def, sleep_after),
    MEMBER(member_double, duet_motion_def, hit_speed),
    MEMBER(member_count, duet_motion_def, event_mask),
    MEMBER(member_bool, duet_motion_def, stage_times),
    {0},
};

// duet.game_motion_def(dims) -> a def that a script may change
static int game_motion_def(lua_State *L)
{
    static const member said[] = {MEMBER(member_count, duet_motion_def, dims),
                                  MEMBER(member_effects, duet_motion_def, wants),
                                  MEMBER(member_double, duet_motion_def, gravity),
                                  MEMBER(member_double, duet_motion_def, slop),
                                  {0}};
    lua_Integer dims = luaL_optinteger(L, 1, 3);
    luaL_argcheck(L, dims == 2 || dims == 3, 1, "2 or 3 dims");
    duet_motion_def def = duet_game_motion_def(NULL, (uint32_t)dims);
    member_push_table(L, said, &def);
    return 1;
}

// The objects that a motion is made of.
typedef struct motion_objects {
    duet_motion_def def;
    const duet_pose *poses;
    const duet_body *bodies; // NULL: all at rest
    uint32_t n;
} motion_objects;

static motion_objects objects_of_scene(lua_State *L, const duet_scene *scene,
                                       duet_device_pair *pair)
{
    motion_objects o = {.def = duet_scene_motion_def(scene, pair),
                        .poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES),
                        .bodies = duet_scene_get_bodies(scene),
                        .n = duet_scene_get_info(scene)->n};
    luaL_argcheck(L, duet_scene_get_info(scene)->shape != DUET_SHAPE_BOUNDS, 2,
                  "a scene of poses: bounds do not move");
    return o;
}

static motion_objects objects_of_arrays(lua_State *L, duet_device_pair *pair)
{
    const array *poses = array_check(L, 2, ARRAY_POSES);
    const array *bodies = lua_isnil(L, 3) ? NULL : array_check(L, 3, ARRAY_BODIES);
    luaL_argcheck(L, poses->n <= UINT32_MAX, 2, "more than 2^32 - 1 objects");
    luaL_argcheck(L, !bodies || bodies->n == poses->n, 3, "as many bodies as poses");
    motion_objects o = {.def = duet_default_motion_def(),
                        .poses = poses->rows,
                        .bodies = bodies ? bodies->rows : NULL,
                        .n = (uint32_t)poses->n};
    o.def.pair = pair;
    return o;
}

// Keeps what the motion on top of the stack needs: the pair at 1, and the script of the def.
static void keep_owners(lua_State *L, int def)
{
    lua_pushvalue(L, 1);
    if (lua_istable(L, def) && lua_getfield(L, def, "script") == LUA_TFUNCTION) {
        lua_createtable(L, 2, 0);
        lua_insert(L, -3);
        lua_rawseti(L, -3, 2);
        lua_rawseti(L, -2, 1);
    } else if (lua_istable(L, def)) {
        lua_pop(L, 1);
    }
    lua_setiuservalue(L, -2, 1);
}

// device_pair:motion(scene, def), or (poses, bodies, def); without bodies all
// are at rest.
static int motion_create(lua_State *L)
{
    duet_error err = {0};
    lua_settop(L, 4);
    duet_device_pair *pair = device_pair_check(L, 1);
    bool of_scene = luaL_testudata(L, 2, "duet.scene");
    motion_objects o =
        of_scene ? objects_of_scene(L, scene_check(L, 2), pair) : objects_of_arrays(L, pair);
    member_read_table(L, of_scene ? 3 : 4, "a motion", def_members, &o.def);
    motion_box *box = class_push(L, &motion_class, sizeof *box);
    keep_owners(L, of_scene ? 3 : 4);
    box->motion = of_scene ? duet_motion_create_from_scene(&o.def, scene_check(L, 2), NULL, &err)
                           : duet_motion_create(&o.def, o.poses, o.bodies, o.n, &err);
    return box->motion ? 1 : class_push_failure(L, &err);
}

static motion_box *check_box(lua_State *L, int index)
{
    motion_box *box = luaL_checkudata(L, index, motion_class.name);
    luaL_argcheck(L, box->motion, index, "the motion is closed");
    return box;
}

duet_motion *motion_check_at(lua_State *L, int index)
{
    return check_box(L, index)->motion;
}

duet_motion *motion_check_lua(lua_State *L)
{
    return motion_check_at(L, 1);
}

static int motion_close(lua_State *L)
{
    motion_box *box = luaL_checkudata(L, 1, motion_class.name);
    if (!box->motion)
        return 0;
    duet_motion_destroy(box->motion);
    box->motion = NULL;
    ++box->steps;
    for (int part = 0; part < 4; ++part)
        ++box->maps[part];
    return 0;
}

uint64_t *motion_maps_lua(lua_State *L)
{
    return check_box(L, 1)->maps;
}

// ---------------------------------------------------------------- steps

typedef struct step_box {
    duet_motion_result result;
    const motion_box *motion; // the uservalue's
    uint64_t step;
} step_box;

static const member step_members[] = {
    MEMBER(member_count, duet_motion_result, step),
    MEMBER(member_double, duet_motion_result, time),
    MEMBER(member_count, duet_motion_result, pairs),
    MEMBER(member_count, duet_motion_result, contacts),
    MEMBER(member_count, duet_motion_result, colours),
    MEMBER(member_bool, duet_motion_result, rebuilt),
    MEMBER(member_count, duet_motion_result, n_events),
    MEMBER(member_count, duet_motion_result, n_stays),
    MEMBER(member_count, duet_motion_result, n_hits),
    MEMBER(member_double, duet_motion_result, total_ms),
    MEMBER(member_bool, duet_motion_result, timed),
    {0},
};

static void check_step(lua_State *L, const step_box *box)
{
    luaL_argcheck(L, box->motion, 1, "the result is closed");
    luaL_argcheck(L, box->motion->motion && box->motion->steps == box->step, 1,
                  "the motion went on: a result holds until then");
}

static const void *step_struct(lua_State *L)
{
    const step_box *box = luaL_checkudata(L, 1, "duet.motion_result");
    check_step(L, box);
    return &box->result;
}

static int step_stages(lua_State *L)
{
    const duet_motion_result *result = step_struct(L);
    stages_push(L, result->stages, result->n_stages);
    return 1;
}

static int push_event(lua_State *L, const duet_motion_result *result, uint64_t i)
{
    lua_pushinteger(L, result->events[i].a);
    lua_pushinteger(L, result->events[i].b);
    lua_pushboolean(L, result->events[i].begins);
    return 3;
}

static int push_stay(lua_State *L, const duet_motion_result *result, uint64_t i)
{
    lua_pushinteger(L, result->stays[i].a);
    lua_pushinteger(L, result->stays[i].b);
    return 2;
}

static int push_hit(lua_State *L, const duet_motion_result *result, uint64_t i)
{
    const duet_hit_event *hit = &result->hits[i];
    lua_pushinteger(L, hit->a);
    lua_pushinteger(L, hit->b);
    for (int k = 0; k < 3; ++k)
        lua_pushnumber(L, hit->point[k]);
    for (int k = 0; k < 3; ++k)
        lua_pushnumber(L, (lua_Number)hit->normal[k]);
    lua_pushnumber(L, (lua_Number)hit->speed);
    lua_pushnumber(L, (lua_Number)hit->impulse);
    return 10;
}

enum { EVENTS, STAYS, HITS };

// One of a result's rows after the other; upvalues: the result, the place, which rows.
static int next_row(lua_State *L)
{
    // Each pushes what is at place i of the result, and says how many values that is.
    static int (*const push[])(lua_State *, const duet_motion_result *, uint64_t) = {
        [EVENTS] = push_event, [STAYS] = push_stay, [HITS] = push_hit};
    const step_box *box = lua_touserdata(L, lua_upvalueindex(1));
    lua_Integer i = lua_tointeger(L, lua_upvalueindex(2));
    lua_Integer which = lua_tointeger(L, lua_upvalueindex(3));
    check_step(L, box);
    const uint64_t counts[] = {box->result.n_events, box->result.n_stays, box->result.n_hits};
    if ((uint64_t)i >= counts[which])
        return 0;
    lua_pushinteger(L, i + 1);
    lua_replace(L, lua_upvalueindex(2));
    return push[which](L, &box->result, (uint64_t)i);
}

// result:events() and others; the upvalue says which.
static int step_rows(lua_State *L)
{
    step_struct(L);
    lua_pushvalue(L, 1);
    lua_pushinteger(L, 0);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_pushcclosure(L, next_row, 3);
    return 1;
}

static int step_close(lua_State *L)
{
    step_box *box = luaL_checkudata(L, 1, "duet.motion_result");
    box->motion = NULL;
    return 0;
}

static const luaL_Reg step_methods[] = {
    {"stages", step_stages}, {"close", step_close}, {NULL, NULL}};
static const lua_shared step_shared[] = {{"events", step_rows, EVENTS},
                                         {"stays", step_rows, STAYS},
                                         {"hits", step_rows, HITS},
                                         {NULL, NULL, 0}};
static const lua_class step_class = {.name = "duet.motion_result",
                                     .methods = step_methods,
                                     .shared = step_shared,
                                     .members = step_members,
                                     .struct_of = step_struct};

int motion_advance_by(lua_State *L, int index, advance_call *advance, void *by)
{
    duet_error err = {0};
    motion_box *motion = check_box(L, index);
    step_box *box = class_push_of(L, &step_class, sizeof *box, index);
    ++motion->steps;
    if (!advance(by, motion->motion, &box->result, &err))
        return class_push_failure(L, &err);
    box->motion = motion;
    box->step = motion->steps;
    return 1;
}

static bool advance_once(void *by, duet_motion *motion, duet_motion_result *result, duet_error *err)
{
    (void)by;
    return duet_motion_advance(motion, result, err);
}

// Calls script(step, motion), where the motion has one.
static void run_script(lua_State *L)
{
    motion_box *box = check_box(L, 1);
    if (lua_getiuservalue(L, 1, 1) == LUA_TTABLE) {
        luaL_argcheck(L, !box->in_script, 1, "its script is running: it cannot be advanced by it");
        lua_rawgeti(L, -1, 2);
        lua_pushinteger(L, (lua_Integer)duet_motion_get_step(box->motion) + 1);
        lua_pushvalue(L, 1);
        box->in_script = true;
        int status = lua_pcall(L, 2, 0, 0);
        box->in_script = false;
        if (status != LUA_OK)
            lua_error(L);
    }
    lua_pop(L, 1);
}

static int motion_advance(lua_State *L)
{
    run_script(L);
    return motion_advance_by(L, 1, advance_once, NULL);
}

// The script acts before the first half. Results of earlier steps are gone with it.
static int motion_advance_begin(lua_State *L)
{
    duet_error err = {0};
    run_script(L);
    motion_box *box = check_box(L, 1);
    bool ok = duet_motion_advance_begin(box->motion, &err);
    box->steps += ok;
    return class_push_done(L, ok, &err);
}

static bool end_advance(void *by, duet_motion *motion, duet_motion_result *result, duet_error *err)
{
    (void)by;
    return duet_motion_advance_end(motion, result, err);
}

static int motion_advance_end(lua_State *L)
{
    return motion_advance_by(L, 1, end_advance, NULL);
}

// ---------------------------------------------------------------- state

static int motion_effects(lua_State *L)
{
    push_effects(L, duet_motion_get_effects(motion_check_lua(L)));
    return 1;
}

// motion:set_plan(plan): what the table leaves out stays
static int motion_set_plan(lua_State *L)
{
    duet_error err = {0};
    static const member argument = {.name = "plan"};
    duet_motion *motion = motion_check_lua(L);
    const duet_motion_def *def = duet_motion_get_def(motion);
    duet_plan plan = def ? def->plan : duet_default_plan(NULL);
    lua_settop(L, 2);
    member_plan.read(L, &argument, &plan);
    return class_push_done(L, duet_motion_set_plan(motion, &plan, &err), &err);
}

// motion:plan() -> the plan by which it seeks pairs; nil if it seeks none
static int motion_plan(lua_State *L)
{
    const duet_plan *plan = duet_motion_get_plan(motion_check_lua(L));
    if (plan)
        member_plan.push(L, NULL, plan);
    else
        lua_pushnil(L);
    return 1;
}

static int motion_step(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)duet_motion_get_step(motion_check_lua(L)));
    return 1;
}

static int motion_length(lua_State *L)
{
    lua_pushinteger(L, duet_motion_get_count(motion_check_lua(L)));
    return 1;
}

// motion:read() or, into an array that is there, motion:read(states)
static int motion_read(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    uint32_t n = duet_motion_get_count(motion);
    if (lua_isnoneornil(L, 2))
        array_push(L, ARRAY_STATES, n);
    else
        lua_settop(L, 2);
    const array *states = array_check(L, -1, ARRAY_STATES);
    luaL_argcheck(L, states->n == n, 2, "an array of #motion states");
    return duet_motion_get_states(motion, states->rows, &err) ? 1 : class_push_failure(L, &err);
}

// motion:read_of(places) -> the states of those
static int motion_read_of(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    const array *ids = array_check(L, 2, ARRAY_PLACES);
    luaL_argcheck(L, ids->n <= UINT32_MAX, 2, "fewer than 2^32 ids");
    array *states = array_push(L, ARRAY_STATES, ids->n);
    return duet_motion_get_states_of(motion, ids->rows, (uint32_t)ids->n, states->rows, &err)
               ? 1
               : class_push_failure(L, &err);
}

// motion:moved() -> places, states
static int motion_moved(lua_State *L)
{
    duet_error err = {0};
    duet_moved moved = {0};
    if (!duet_motion_get_moved(motion_check_lua(L), &moved, &err))
        return class_push_failure(L, &err);
    array_push_copy(L, ARRAY_PLACES, moved.places, moved.n);
    array_push_copy(L, ARRAY_STATES, moved.states, moved.n);
    return 2;
}

// duet.states_between(from, to, fraction): row by row
static int states_between(lua_State *L)
{
    const array *from = array_check(L, 1, ARRAY_STATES), *to = array_check(L, 2, ARRAY_STATES);
    double fraction = luaL_checknumber(L, 3);
    luaL_argcheck(L, from->n == to->n, 2, "as many states as the first");
    const duet_state *a = from->rows, *b = to->rows;
    duet_state *out = array_push(L, ARRAY_STATES, from->n)->rows;
    for (uint64_t i = 0; i < from->n; ++i)
        out[i] = duet_state_between(&a[i], &b[i], fraction);
    return 1;
}

static int motion_hash(lua_State *L)
{
    duet_error err = {0};
    uint64_t hash = 0;
    if (!duet_motion_get_hash(motion_check_lua(L), &hash, &err))
        return class_push_failure(L, &err);
    array_push_hash(L, hash);
    return 1;
}

static const member energy_members[] = {
    MEMBER(member_double, duet_energy, kinetic),   MEMBER(member_double, duet_energy, turning),
    MEMBER(member_double, duet_energy, potential), MEMBER(member_double, duet_energy, momentum),
    MEMBER(member_double, duet_energy, angular),   {0},
};

static int motion_energy(lua_State *L)
{
    duet_error err = {0};
    duet_energy energy = {0};
    if (!duet_motion_get_energy(motion_check_lua(L), &energy, &err))
        return class_push_failure(L, &err);
    member_push_table(L, energy_members, &energy);
    return 1;
}

static int motion_poses(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    array *poses = array_push(L, ARRAY_POSES, duet_motion_get_count(motion));
    return duet_motion_get_poses(motion, poses->rows, &err) ? 1 : class_push_failure(L, &err);
}

static int motion_rounded_boxes(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    array *boxes = array_push(L, ARRAY_ROUNDED_BOXES, duet_motion_get_count(motion));
    return duet_motion_get_rounded_boxes(motion, boxes->rows, &err) ? 1
                                                                    : class_push_failure(L, &err);
}

static int motion_asleep(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    array *asleep = array_push(L, ARRAY_ANSWERS, duet_motion_get_count(motion));
    return duet_motion_get_asleep(motion, asleep->rows, &err) ? 1 : class_push_failure(L, &err);
}

static int motion_contacts(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    array *found = array_push_empty(L, ARRAY_CONTACTS);
    duet_contact *contacts = NULL;
    uint64_t n = 0;
    if (!duet_motion_get_contacts(motion, &contacts, &n, &err))
        return class_push_failure(L, &err);
    array_own(found, contacts, n);
    return 1;
}

static int motion_save(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    const char *path = luaL_checkstring(L, 2);
    policy_check_trusted(L, "saving a motion");
    return class_push_done(L, duet_motion_save(motion, path, &err), &err);
}

static int motion_load(lua_State *L)
{
    duet_error err = {0};
    motion_box *box = check_box(L, 1);
    const char *path = luaL_checkstring(L, 2);
    policy_check_read(L, path);
    ++box->steps;
    return class_push_done(L, duet_motion_load(box->motion, path, &err), &err);
}

static int motion_record(lua_State *L)
{
    duet_error err = {0};
    return class_push_done(L, duet_motion_record(motion_check_lua(L), &err), &err);
}

static int motion_save_recording(lua_State *L)
{
    duet_error err = {0};
    duet_motion *motion = motion_check_lua(L);
    const char *path = luaL_checkstring(L, 2);
    policy_check_trusted(L, "saving a recording");
    return class_push_done(L, duet_motion_save_recording(motion, path, &err), &err);
}

static const member effect_members[] = {
    MEMBER(member_string, duet_effect_info, name),
    MEMBER(member_bool, duet_effect_info, active),
    MEMBER(member_string, duet_effect_info, called_by),
    MEMBER(member_string, duet_effect_info, kernels),
    MEMBER(member_count, duet_effect_info, bytes),
    {0},
};

// One table an effect.
static int motion_explain(lua_State *L)
{
    duet_effect_info info = {0};
    const duet_motion *motion = motion_check_lua(L);
    lua_newtable(L);
    for (uint32_t i = 0; duet_motion_explain(motion, i, &info); ++i) {
        member_push_table(L, effect_members, &info);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static const member substep_members[] = {
    MEMBER(member_count, duet_substep_info, substeps),
    MEMBER(member_bool, duet_substep_info, chosen),
    MEMBER(member_count, duet_substep_info, layers),
    MEMBER(member_double, duet_substep_info, edge),
    {0},
};

static int motion_explain_substeps(lua_State *L)
{
    duet_substep_info info = {0};
    duet_motion_explain_substeps(motion_check_lua(L), &info);
    member_push_table(L, substep_members, &info);
    return 1;
}

static const luaL_Reg methods[] = {{"advance", motion_advance},
                                   {"advance_begin", motion_advance_begin},
                                   {"advance_end", motion_advance_end},
                                   {"effects", motion_effects},
                                   {"plan", motion_plan},
                                   {"set_plan", motion_set_plan},
                                   {"read", motion_read},
                                   {"read_of", motion_read_of},
                                   {"moved", motion_moved},
                                   {"poses", motion_poses},
                                   {"rounded_boxes", motion_rounded_boxes},
                                   {"asleep", motion_asleep},
                                   {"hash", motion_hash},
                                   {"energy", motion_energy},
                                   {"contacts", motion_contacts},
                                   {"save", motion_save},
                                   {"load", motion_load},
                                   {"explain", motion_explain},
                                   {"explain_substeps", motion_explain_substeps},
                                   {"close", motion_close},
                                   {"record", motion_record},
                                   {"save_recording", motion_save_recording},
                                   {"step", motion_step},
                                   {NULL, NULL}};
static const luaL_Reg metas[] = {{"__len", motion_length}, {NULL, NULL}};
static int motion_about(lua_State *L)
{
    const duet_motion *motion = motion_check_lua(L);
    uint32_t effects = duet_motion_get_effects(motion);
    const char *before = "";
    lua_pushfstring(L, "objects = %d, effects = { ", (int)duet_motion_get_count(motion));
    for (uint32_t i = 0; effect_at(i); ++i) {
        if (!(effects & 1u << i))
            continue;
        lua_pushfstring(L, "%s%s", before, effect_at(i));
        lua_concat(L, 2);
        before = ", ";
    }
    lua_pushliteral(L, " }");
    lua_concat(L, 2);
    return 1;
}

static const lua_class motion_class = {
    .name = "duet.motion",
    .methods = methods,
    .metas = metas,
    .about = motion_about,
};

void motion_open_lua(lua_State *L)
{
    static const luaL_Reg functions[] = {{"effects", list_effects},
                                         {"game_motion_def", game_motion_def},
                                         {"states_between", states_between},
                                         {NULL, NULL}};
    static const luaL_Reg of_pair[] = {{"motion", motion_create}, {NULL, NULL}};
    class_open(L, &motion_class);
    class_add_methods(L, "duet.device_pair", of_pair, NULL);
    class_open(L, &step_class);
    luaL_setfuncs(L, functions, 0);
    lua_pushinteger(L, (lua_Integer)DUET_NO_BODY);
    lua_setfield(L, -2, "NO_BODY");
}
