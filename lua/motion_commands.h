// SPDX-License-Identifier: MIT
// Commands as scripts give them, to a motion or to one over ranks.
#ifndef LUA_MOTION_COMMANDS_H
#define LUA_MOTION_COMMANDS_H

#include "runtime/commands/command.h"

#include <lua.h>

// Reads a method's command, whose number is the method's upvalue, from the arguments behind its
// object. set_def changes *def, which the command then has. Ids of bodies that come are an array
// on the top of the stack.
command command_read_lua(lua_State *L, duet_motion_def *def);

// Pushes what the method returns.
int command_push_lua(lua_State *L, const command *c, bool ok, const duet_error *err);

// The bodies at 2: ids, or { first = place, n = count }, or one id.
duet_body_list command_check_list_lua(lua_State *L);

#endif
