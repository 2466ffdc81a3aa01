// SPDX-License-Identifier: MIT
// Steps of a motion, and what they tell: counts, times, contacts that begin, stay and hit.
#include "lua/motion.h"

typedef struct step_box {
    duet_motion_result result;
    const motion_box *motion; // the uservalue's
    uint64_t step;
} step_box;

static const field step_fields[] = {
    FIELDS(duet_motion_result, step, time, pairs, contacts, colours, rebuilt, n_events, n_stays,
           n_hits, total_ms, timed),
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

static int motion_result_stages(lua_State *L)
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

static int motion_result_close(lua_State *L)
{
    step_box *box = luaL_checkudata(L, 1, "duet.motion_result");
    box->motion = NULL;
    return 0;
}

static const lua_class step_class = {
    .name = "duet.motion_result", .fields = step_fields, .struct_of = step_struct};

int motion_advance_by(lua_State *L, int index, advance_call *advance, void *by)
{
    duet_error err = {0};
    motion_box *motion = motion_check_box(L, index);
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

// Calls script(step, motion), if the motion has one.
static void run_script(lua_State *L, int index)
{
    motion_box *box = motion_check_box(L, index);
    if (lua_getiuservalue(L, index, 1) == LUA_TTABLE) {
        luaL_argcheck(L, !box->in_script, 1, "its script is running: it cannot be advanced by it");
        lua_rawgeti(L, -1, 2);
        lua_pushinteger(L, (lua_Integer)duet_motion_get_step(box->motion) + 1);
        lua_pushvalue(L, index);
        box->in_script = true;
        int status = lua_pcall(L, 2, 0, 0);
        box->in_script = false;
        if (status != LUA_OK)
            lua_error(L);
    }
    lua_pop(L, 1);
}

int motion_run_by(lua_State *L, int index, advance_call *advance, void *by)
{
    run_script(L, index);
    return motion_advance_by(L, index, advance, by);
}

static int motion_advance(lua_State *L)
{
    return motion_run_by(L, 1, advance_once, NULL);
}

// The script acts before the first half. Results of earlier steps are gone with it.
static int motion_advance_begin(lua_State *L)
{
    duet_error err = {0};
    run_script(L, 1);
    motion_box *box = motion_check_box(L, 1);
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

const lua_noun motion_step_noun = {
    {&step_class},
    (const lua_method[]){METHODS(motion, advance, advance_begin, advance_end),
                         METHODS(motion_result, stages, close),
                         {"duet.motion_result:events", step_rows, EVENTS},
                         {"duet.motion_result:stays", step_rows, STAYS},
                         {"duet.motion_result:hits", step_rows, HITS},
                         {0}}};
