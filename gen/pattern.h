// SPDX-License-Identifier: MIT
// find, match, gmatch and gsub for scripts: Lua's patterns as its manual has
// them, by a matcher that takes its steps from what the script has left. A
// pattern can need more steps than there is time, whatever its length.
//
// Letters and other classes are ASCII's, whatever the locale is.
#ifndef GEN_PATTERN_H
#define GEN_PATTERN_H

#include <lua.h>

// Puts the four functions into the table on top of the stack.
void pattern_open(lua_State *L);

#endif
