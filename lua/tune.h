// SPDX-License-Identifier: MIT
// Modes that a tuning and an online plan take.
#ifndef LUA_TUNE_H
#define LUA_TUNE_H

#include "duet_tune.h"
#include "lua/nouns.h"

// Copies the modes of a list, and returns how many there are.
uint32_t tune_take_modes(const field_enum_list *list, duet_mode modes[FIELD_NAMES]);

#endif
