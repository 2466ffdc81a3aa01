// SPDX-License-Identifier: MIT
// What a script reads of a motion: states, poses, sleep, sums and contacts.
#include "lua/motion.h"

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

static int motion_energy(lua_State *L)
{
    duet_error err = {0};
    duet_energy energy = {0};
    if (!duet_motion_get_energy(motion_check_lua(L), &energy, &err))
        return class_push_failure(L, &err);
    field_push_table(L, FIELD_LIST(duet_energy, kinetic, turning, potential, momentum, angular),
                     &energy);
    return 1;
}

// motion:poses() and others, a row for each body; the upvalue is the kind of rows.
static int motion_rows(lua_State *L)
{
    duet_error err = {0};
    array_kind kind = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    duet_motion *motion = motion_check_lua(L);
    void *rows = array_push(L, kind, duet_motion_get_count(motion))->rows;
    bool ok = kind == ARRAY_POSES           ? duet_motion_get_poses(motion, rows, &err)
              : kind == ARRAY_ROUNDED_BOXES ? duet_motion_get_rounded_boxes(motion, rows, &err)
                                            : duet_motion_get_asleep(motion, rows, &err);
    return ok ? 1 : class_push_failure(L, &err);
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

const lua_noun motion_state_noun = {
    {NULL},
    (const lua_method[]){{"duet.states_between", states_between, 0},
                         METHODS(motion, read, read_of, moved, hash, energy, contacts),
                         {"duet.motion:poses", motion_rows, ARRAY_POSES},
                         {"duet.motion:rounded_boxes", motion_rows, ARRAY_ROUNDED_BOXES},
                         {"duet.motion:asleep", motion_rows, ARRAY_ANSWERS},
                         {0}}};
