// SPDX-License-Identifier: MIT
#include "base/error.h"

#include "base/plain_numbers.h"
#include "base/visible.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A compiler log has many lines; an error has one.
static void join_lines(char *line, size_t size)
{
    size_t length = strlen(line);
    while (length > 0 && (line[length - 1] == '\n' || line[length - 1] == ' '))
        line[--length] = '\0';
    for (char *at = line; *at; ++at)
        if (*at == '\n' || *at == '\r' || *at == '\t')
            *at = ' ';
    visible_line(line, size);
}

// "CL_OUT_OF_RESOURCES" for -5; "CL error" outside the list.
static const char *cl_name(int cl_code)
{
    static const struct {
        int code;
        const char *name;
    } names[] = {
        {-1, "CL_DEVICE_NOT_FOUND"},
        {-2, "CL_DEVICE_NOT_AVAILABLE"},
        {-3, "CL_COMPILER_NOT_AVAILABLE"},
        {-4, "CL_MEM_OBJECT_ALLOCATION_FAILURE"},
        {-5, "CL_OUT_OF_RESOURCES"},
        {-6, "CL_OUT_OF_HOST_MEMORY"},
        {-11, "CL_BUILD_PROGRAM_FAILURE"},
        {-18, "CL_DEVICE_PARTITION_FAILED"},
        {-30, "CL_INVALID_VALUE"},
        {-33, "CL_INVALID_DEVICE"},
        {-34, "CL_INVALID_CONTEXT"},
        {-36, "CL_INVALID_COMMAND_QUEUE"},
        {-38, "CL_INVALID_MEM_OBJECT"},
        {-42, "CL_INVALID_BINARY"},
        {-45, "CL_INVALID_PROGRAM_EXECUTABLE"},
        {-46, "CL_INVALID_KERNEL_NAME"},
        {-48, "CL_INVALID_KERNEL"},
        {-49, "CL_INVALID_ARG_INDEX"},
        {-50, "CL_INVALID_ARG_VALUE"},
        {-51, "CL_INVALID_ARG_SIZE"},
        {-52, "CL_INVALID_KERNEL_ARGS"},
        {-54, "CL_INVALID_WORK_GROUP_SIZE"},
        {-55, "CL_INVALID_WORK_ITEM_SIZE"},
        {-61, "CL_INVALID_BUFFER_SIZE"},
        {-63, "CL_INVALID_GLOBAL_WORK_SIZE"},
        {-1001, "CL_PLATFORM_NOT_FOUND_KHR"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (names[i].code == cl_code)
            return names[i].name;
    return "CL error";
}

// ---------------------------------------------------------------- public calls

void public_call_begin(public_call *call, duet_error *err)
{
    *call = (public_call){.err = err, .numbers = plain_numbers_begin()};
    if (!err)
        return;
    call->outer = err->calls;
    call->before = err->status;
    ++err->calls;
    if (call->outer == 0)
        err->status = DUET_STATUS_OK;
}

void public_call_end(public_call *call)
{
    plain_numbers_end(call->numbers);
    if (!call->err)
        return;
    call->err->calls = call->outer;
    if (call->outer == 0 && call->err->status == DUET_STATUS_OK)
        call->err->status = call->before;
}

// ---------------------------------------------------------------- the line

// The first failure is kept.
static bool is_free(const duet_error *err)
{
    return err && err->status == DUET_STATUS_OK;
}

static void fill(duet_error *err, duet_status status, const char *format, va_list args)
{
    visible_write(err->text, sizeof err->text, format, args);
    join_lines(err->text, sizeof err->text);
    err->status = status;
    err->cl_code = 0;
}

bool error_set(duet_error *err, duet_status status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    if (is_free(err))
        fill(err, status, format, args);
    va_end(args);
    return false;
}

bool error_copy(duet_error *err, const duet_error *why)
{
    if (!is_free(err))
        return false;
    unsigned calls = err->calls;
    *err = *why;
    err->calls = calls;
    return false;
}

bool error_set_cl(duet_error *err, int cl_code, const char *format, ...)
{
    if (!is_free(err))
        return false;
    bool memory = cl_code == -4 || cl_code == -6 || cl_code == -61;
    va_list args;
    va_start(args, format);
    fill(err, memory ? DUET_STATUS_NO_MEMORY : DUET_STATUS_DEVICE_FAILED, format, args);
    va_end(args);
    size_t used = strlen(err->text);
    snprintf(err->text + used, sizeof err->text - used, ": %s (%d)", cl_name(cl_code), cl_code);
    err->cl_code = cl_code;
    return false;
}

bool error_given(const void *pointer, const char *call, const char *argument, duet_error *err)
{
    return pointer || bad_argument(err, "%s: %s is NULL; expected a valid pointer", call, argument);
}

bool error_def(bool is_ours, const char *noun, const char *maker, duet_error *err)
{
    return is_ours || bad_argument(err, "the %s's def does not come from %s", noun, maker);
}

bool error_def_pair(const void *pair, const char *noun, duet_error *err)
{
    return pair || bad_argument(err, "the %s's def has no device pair", noun);
}

bool error_def_dims(uint32_t dims, duet_error *err)
{
    return dims == 2 || dims == 3 || bad_argument(err, "dims is %u; expected 2 or 3", dims);
}

const char *duet_status_name(duet_status status)
{
    switch (status) {
#define X(name, text)        \
    case DUET_STATUS_##name: \
        return #name;
        DUET_STATUS_LIST(X)
#undef X
    }
    return "UNKNOWN";
}
