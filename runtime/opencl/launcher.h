// SPDX-License-Identifier: MIT
// Where a kernel's arguments are found when it is launched.
//
// A module that launches kernels keeps the values of their arguments in one struct and
// names each of them in a table. When a kernel is built, each argument of its card is
// looked up there by name and type, so that a launch need only be told where the struct is.
#ifndef RUNTIME_LAUNCHER_H
#define RUNTIME_LAUNCHER_H

#include "gen/gen.h"

#include <CL/cl.h>
#include <stddef.h>

// A value that DOUBLE makes double: of cards' types real and real4.
typedef union arg_real {
    cl_float f;
    cl_double d;
} arg_real;

typedef union arg_real4 {
    cl_float4 f;
    cl_double4 d;
} arg_real4;

typedef struct binding {
    const char *name;
    const char *type; // the card's type; "float4 *" for a buffer of float4
    uint32_t at;      // offset of the cl_mem or the value in the struct
} binding;

// Ends with a binding without a name.
typedef const binding *bindings;

#define BIND_TYPE(x)              \
    _Generic((x), cl_uint         \
             : "uint", cl_float   \
             : "float", cl_float4 \
             : "float4", cl_int4  \
             : "int4", arg_real   \
             : "real", arg_real4  \
             : "real4")

// A value is a member of the struct, its type that of the member; a buffer's `member` is
// a struct buffer, and `type` what it holds: "float4 *".
#define BIND_VALUE(owner, name, member)                                \
    {                                                                  \
        name, BIND_TYPE(((owner *)0)->member), offsetof(owner, member) \
    }
#define BIND_BUFFER(owner, name, type, member)  \
    {                                           \
        name, type, offsetof(owner, member.mem) \
    }

// The places of one kernel's arguments, in the order of its parameters.
typedef struct launcher {
    struct {
        uint32_t at;
        uint32_t bytes;
    } args[GEN_MAX_ARGS];
    uint32_t n;
} launcher;

#endif
