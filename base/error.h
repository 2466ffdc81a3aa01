// SPDX-License-Identifier: MIT
// How Duet's own code fills a duet_error: once, with one line.
#ifndef BASE_ERROR_H
#define BASE_ERROR_H

#include "duet_error.h"

#include <stdbool.h>

// Fills err unless it is NULL or holds an earlier failure; returns false, so
// that a failing function can end with it. A line break in the text becomes
// "; " and what does not fit is cut.
bool error_set(duet_error *err, duet_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// The same for makers: NULL.
#define error_null(...) (error_set(__VA_ARGS__), NULL)

// The same with a failure that another call told.
bool error_copy(duet_error *err, const duet_error *why);

// The same for a failed OpenCL call: appends the code's name.
bool error_set_cl(duet_error *err, int cl_code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// False with BAD_ARGUMENT if a required argument of a public call is NULL: the line names the
// call and the argument.
bool error_given(const void *pointer, const char *call, const char *argument, duet_error *err);

#endif
