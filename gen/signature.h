// SPDX-License-Identifier: MIT
// The arguments of a kernel's entries, as its card lists them: for each entry a
// text with an argument a line,
//
//   [volatile] [const | constant] TYPE [*]NAME [[only] if CONDITION]
//
// in the order of the kernel's parameters. A star makes it a buffer, in __global
// memory or with `constant` in __constant. TYPE is one of OpenCL's, or real, real2,
// real4, which DOUBLE makes double or float. The condition is a Lua comparison of
// the card's parameters.
#ifndef GEN_SIGNATURE_H
#define GEN_SIGNATURE_H

#include "base/text.h"
#include "gen/gen.h"

#include <lua.h>

typedef struct signature_arg {
    gen_arg arg;
    int condition; // a function in the state's registry, or LUA_NOREF: always there
} signature_arg;

typedef struct signature {
    char entry[GEN_NAME];
    signature_arg args[GEN_MAX_ARGS];
    uint32_t n;
} signature;

// Pushes a table in which each parameter of a config is a field.
void signature_push_config(lua_State *L, const gen_setting *config, uint32_t n);

// Reads the table `args` of a card, on top of the stack, ordered by the entries' names; raises if
// it is wrong. The list is the caller's, to free.
void signature_read(lua_State *L, signature **list, uint32_t *n);

// The entry's arguments under a config. Raises if a condition is no comparison.
void signature_resolve(lua_State *L, const signature *s, const gen_setting *config, uint32_t n,
                       gen_entry *entry);

// Adds the macro ENTRY_ARGS of each entry: its parameters.
void signature_write(const gen_entry *entries, uint32_t n, text *out);

// Adds ARG_FIELDS, the arguments of all entries as members of a struct, with those that the config
// leaves out unless they are there `only if` it does not, and ENTRY_VALUES, what an entry
// initializes of that struct.
void signature_write_fields(const gen_entry *entries, uint32_t n, text *out);

#endif
