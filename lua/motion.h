// SPDX-License-Identifier: MIT
// A motion as scripts have it, for the files that give it methods.
#ifndef LUA_MOTION_H
#define LUA_MOTION_H

#include "lua/nouns.h"

// The uservalue is its device pair, or { pair, script } if it has a script.
typedef struct motion_box {
    duet_motion *motion;
    uint64_t steps;   // results of earlier ones no longer hold
    uint64_t maps[4]; // so with mapped rows, by part of the state
    bool in_script;
} motion_box;

motion_box *motion_check_box(lua_State *L, int index); // one that is open

extern const field motion_def_fields[];

// Read a ground from the table on top of the stack and push it, as a userdata; raise an error for
// what is none.
const duet_heights *motion_push_heights(lua_State *L);
const duet_mesh *motion_push_mesh(lua_State *L);

#endif
