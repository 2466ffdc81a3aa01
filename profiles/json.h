// SPDX-License-Identifier: MIT
// JSON that comes from outside this module. SQL's own check is off in a store,
// whose text is not trusted, so it is checked here.
#ifndef PROFILES_JSON_H
#define PROFILES_JSON_H

#include "base/error.h"

// BAD_ARGUMENT, with what, where the text is not one JSON object.
bool json_check_object(const char *what, const char *chars, duet_error *err);

#endif
