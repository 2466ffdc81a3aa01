// SPDX-License-Identifier: MIT
#ifndef RUNTIME_SCENE_HEIGHTS_H
#define RUNTIME_SCENE_HEIGHTS_H

#include "runtime/duet.h"

#include <lua.h>

// Reads a ground from the table on top of the stack, but for its values. Returns what is wrong, or
// NULL.
const char *heights_read(lua_State *L, duet_heights *h);

// Reads the values of that ground [ny][nx], likewise. The caller has the memory: it may be Lua's.
const char *heights_read_values(lua_State *L, const duet_heights *h, float *to);

#endif
