// SPDX-License-Identifier: MIT
// How much may be wrong, and the fields of Lua tables that say so.
#ifndef RUNTIME_ACCURACY_H
#define RUNTIME_ACCURACY_H

#include "runtime/duet.h"

#include <lua.h>

// BAD_ARGUMENT for what no rate can be; `whose` says where it was given.
bool accuracy_check(const duet_accuracy *accuracy, const char *whose, duet_error *err);

// The field `level` of the table at that stack index; what is nil changes
// nothing. Raises as gen/field.h does.
void accuracy_read_level(lua_State *L, int table, duet_level *level);

// The field `accuracy`, a table { missed =, false_rate = }; what it leaves out
// is 0. False where it is nil.
bool accuracy_read(lua_State *L, int table, duet_accuracy *accuracy);

#endif
