// SPDX-License-Identifier: MIT
// How Duet's own code fills a duet_error: once in each public call, with one line.
#ifndef BASE_ERROR_H
#define BASE_ERROR_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

// The first statement of each public call that takes an error. Within it err begins without a
// failure, so that the first one of this call is kept; if the call does not fail, err is afterwards
// what it was before. If err is that of a public call under way, it stays that call's, which err
// itself says: ranks that are simulated change places within a thread. Numbers have points within
// it, whatever the application's language.
#define PUBLIC_CALL(err)                                         \
    __attribute__((cleanup(public_call_end))) public_call call_; \
    public_call_begin(&call_, err)

typedef struct public_call {
    duet_error *err;    // may be NULL
    unsigned outer;     // calls that it was of already
    duet_status before; // its status when the call began
    void *numbers;      // of plain_numbers_begin
} public_call;

void public_call_begin(public_call *call, duet_error *err);
void public_call_end(public_call *call);

// Fills err unless it is NULL or holds an earlier failure; returns false, so
// that a failing function can end with it. A line break in the text becomes
// "; " and what does not fit is cut.
bool error_set(duet_error *err, duet_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// The same for what a caller or an option gives, and for what a file holds.
#define bad_argument(err, ...) error_set(err, DUET_STATUS_BAD_ARGUMENT, __VA_ARGS__)
#define bad_input(err, ...) error_set(err, DUET_STATUS_BAD_INPUT, __VA_ARGS__)

// The same for memory that the host does not have, from words for what it was to hold.
#define no_memory(err, ...) error_set(err, DUET_STATUS_NO_MEMORY, "no memory for " __VA_ARGS__)

// The same for makers: NULL.
#define error_null(...) (error_set(__VA_ARGS__), NULL)
#define null_no_memory(...) (no_memory(__VA_ARGS__), NULL)

// The same with a failure that another call told.
bool error_copy(duet_error *err, const duet_error *why);

// The same for a failed OpenCL call: appends the code's name.
bool error_set_cl(duet_error *err, int cl_code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// False with BAD_ARGUMENT if a required argument of a public call is NULL: the line names the
// call and the argument.
bool error_given(const void *pointer, const char *call, const char *argument, duet_error *err);

// The first checks of a noun's def, BAD_ARGUMENT otherwise: it comes from `maker`, as its cookie
// says; it has a device pair, and 2 or 3 dimensions.
bool error_def(bool is_ours, const char *noun, const char *maker, duet_error *err);
bool error_def_pair(const void *pair, const char *noun, duet_error *err);
bool error_def_dims(uint32_t dims, duet_error *err);

#endif
