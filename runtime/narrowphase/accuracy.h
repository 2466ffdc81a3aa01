// SPDX-License-Identifier: MIT
// How much may be wrong, and the field of Lua tables that says so.
#ifndef RUNTIME_ACCURACY_H
#define RUNTIME_ACCURACY_H

#include "gen/field.h"
#include "runtime/duet.h"

// BAD_ARGUMENT for what no rate can be; `whose` says where it was given.
bool accuracy_check(const duet_accuracy *accuracy, const char *whose, duet_error *err);

// Name of a level; NULL past the last.
const char *level_name(int level);

// A duet_accuracy as a table { missed =, false_rate = }; what it leaves out is 0.
extern const field_type field_accuracy;

#endif
