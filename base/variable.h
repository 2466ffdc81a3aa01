// SPDX-License-Identifier: MIT
// Environment variables. One that is empty is as if it were not set.
#ifndef BASE_VARIABLE_H
#define BASE_VARIABLE_H

#include "base/error.h"

const char *variable_text(const char *name); // NULL: it is not set

// Reads seconds, 0 or more, and none too many for a clock; `otherwise` if it is not set.
// BAD_ARGUMENT names it.
bool variable_seconds(const char *name, double otherwise, double *seconds, duet_error *err);

#endif
