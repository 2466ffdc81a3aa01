// SPDX-License-Identifier: MIT
// What went wrong, as a value that the caller owns.
//
// Makers return a pointer or NULL and doers return bool; both take a
// duet_error last. NULL is allowed there. A call that fails fills it with its
// own failure, the first one if there are several, whatever it held before. A
// call that succeeds leaves it as it was. So one error can be passed through
// several calls; at the end it holds the last failure, if there was one.
#ifndef DUET_ERROR_H
#define DUET_ERROR_H

// Around what the public headers declare, which is C to C++ too.
#ifdef __cplusplus
#define DUET_C_BEGIN extern "C" {
#define DUET_C_END }
#else
#define DUET_C_BEGIN
#define DUET_C_END
#endif

#if defined(__GNUC__)
#define DUET_API __attribute__((visibility("default")))
#else
#define DUET_API
#endif

DUET_C_BEGIN

// name, what it means in general
#define DUET_STATUS_LIST(X)                                                         \
    X(OK, "no error")                                                               \
    X(BAD_ARGUMENT, "an argument is out of its range, or nothing has such a name")  \
    X(BAD_INPUT, "an input file or its data is malformed")                          \
    X(NOT_FOUND, "a file does not exist, or nothing meets what was asked for")      \
    X(NO_DEVICE, "there is no OpenCL device to work on")                            \
    X(BUILD_FAILED, "a kernel does not generate or compile")                        \
    X(DEVICE_FAILED, "an OpenCL call failed")                                       \
    X(NO_MEMORY, "host or device memory does not suffice")                          \
    X(TOO_MANY, "a count is above what can be held")                                \
    X(CELL_TOO_SMALL, "the cell edge is below the largest object")                  \
    X(BAD_OBJECT, "an object's pose is not a number, negative or without rotation") \
    X(WRONG_RESULT, "a verified result differs from the reference")                 \
    X(STORE_FAILED, "the profile store cannot be read or written")                  \
    X(INTERRUPTED, "stopped by the user")                                           \
    X(IO_FAILED, "a file cannot be read or written")

typedef enum duet_status {
#define X(name, text) DUET_STATUS_##name,
    DUET_STATUS_LIST(X)
#undef X
} duet_status;

// Begin with {0}, or in C++ with {}.
typedef struct duet_error {
    int cl_code; // the OpenCL code where a device failed, else 0
    duet_status status;
    char text[480]; // one English line: what, where, what was expected
    unsigned calls; // Duet's own: public calls under way that fill it
} duet_error;

// "BUILD_FAILED" for DUET_STATUS_BUILD_FAILED; "UNKNOWN" outside the list.
DUET_API const char *duet_status_name(duet_status status);

DUET_C_END

#endif
