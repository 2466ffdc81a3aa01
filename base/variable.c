// SPDX-License-Identifier: MIT
#include "base/variable.h"

#include <stdlib.h>

static const double MOST_SECONDS = 1e9;

const char *variable_text(const char *name)
{
    const char *value = getenv(name);
    return value && *value ? value : NULL;
}

bool variable_seconds(const char *name, double otherwise, double *seconds, duet_error *err)
{
    const char *value = variable_text(name);
    char *end = NULL;
    *seconds = value ? strtod(value, &end) : otherwise;
    return !value || (*seconds >= 0 && *seconds <= MOST_SECONDS && !*end) ||
           bad_argument(err, "%s is '%s'; expected a number of seconds from 0 to 1e9", name, value);
}
