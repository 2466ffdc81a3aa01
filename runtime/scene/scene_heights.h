// SPDX-License-Identifier: MIT
#ifndef RUNTIME_SCENE_HEIGHTS_H
#define RUNTIME_SCENE_HEIGHTS_H

#include "runtime/duet.h"

#include <lua.h>

// Reads a ground from the table on top of the stack. Returns what is wrong, or NULL; the caller
// then frees *values, which are h's.
const char *heights_read(lua_State *L, duet_heights *h, float **values);

#endif
