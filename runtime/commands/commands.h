// SPDX-License-Identifier: MIT
// Every command by its number, as public calls, replays and Lua give it.
#ifndef RUNTIME_COMMANDS_H
#define RUNTIME_COMMANDS_H

#include "runtime/commands/command.h"

// NULL: no command has that number.
const command_op *command_op_at(uint32_t number);

// Checks a command, carries it out, and adds it to what is recorded. After BAD_ARGUMENT and
// BAD_OBJECT nothing has changed.
bool command_give(duet_motion *m, command *c, duet_error *err);

// Parts of it, for a motion over ranks: whether a command has the rows that it needs; and whether a
// motion has the effect that it needs, and finds nothing wrong with it once its places are known.
bool command_check_given(const command *c, duet_error *err);
bool command_look(duet_motion *m, command *c, duet_error *err);

#endif
