// SPDX-License-Identifier: MIT
// What commands leave in the file of a motion, after its buffers.
#ifndef RUNTIME_MOTION_FILE_COMMANDS_H
#define RUNTIME_MOTION_FILE_COMMANDS_H

#include "base/text.h"
#include "runtime/dynamics/motion_commands.h"

// Adds the part to a file.
bool motion_add_commands(duet_motion *m, text *file, duet_error *err);

// How long the part is that begins at `bytes`, of which there are `length`; more than these
// where it is cut short.
size_t motion_commands_size(const char *bytes, size_t length, uint32_t n);

// A motion with the objects and commands of such a part, or as it was given to
// duet_motion_create where bytes is NULL; *as begins as a copy of the motion, and gets its
// own of all that is by object. BAD_INPUT where a motion could not have saved it.
bool motion_take_commands(duet_motion *as, const char *bytes, const char *path, duet_error *err);

// The motion's state from then on; what it had is freed, or what *as has where it failed.
void motion_adopt(duet_motion *m, duet_motion *as);
void motion_forget_copy(duet_motion *as);

#endif
