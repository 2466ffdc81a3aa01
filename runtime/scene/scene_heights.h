// SPDX-License-Identifier: MIT
#ifndef RUNTIME_SCENE_HEIGHTS_H
#define RUNTIME_SCENE_HEIGHTS_H

#include "gen/field.h"
#include "runtime/duet.h"

// Reads a ground from the table on top of the stack, but for its values; raises for what is none.
void heights_read(lua_State *L, duet_heights *h);

// Reads the values of that ground [ny][nx], likewise. The caller has the memory: it may be Lua's.
void heights_read_values(lua_State *L, const duet_heights *h, float *to);

#endif
