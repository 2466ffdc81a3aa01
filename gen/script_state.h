// SPDX-License-Identifier: MIT
// A private Lua state's insides, for script.c and script_limits.c.
#ifndef GEN_SCRIPT_STATE_H
#define GEN_SCRIPT_STATE_H

#include "base/budget.h"
#include "base/text.h"
#include "gen/script.h"

typedef enum passed { NOTHING, INSTRUCTIONS, TIME, STOP, HOST_MEMORY } passed;

struct script {
    lua_State *lua;
    script_limits limits;
    size_t used_bytes;
    size_t largest_bytes;       // the largest string or block of userdata that there was
    size_t asked_bytes;         // since the last look at the clock
    uint64_t instructions_left; // instructions that the running call may still take
    uint64_t spent;             // since the last look at the clock
    budget budget;
    uint64_t left_ns; // the rest of the last call's time, for closing
    passed passed;    // the limit that the running call has passed
    lua_Integer n_shown;
    int depth;        // calls inside calls; the outermost one sets the limits
    uintptr_t stack;  // the block that holds Lua's stack
    bool stack_moves; // Lua asks for another one; what looks at the stack would crash
    bool stack_grew;  // since the last look at the limits
    char place[400];  // "name:line", where that was or memory ran out last
    text name;        // name of the chunk loaded last, or else the sandbox
    text source;      // its text
};

script *script_of(lua_State *L); // NULL: the state is none of a script's

// A call of the state's: the outermost one has all that the limits leave.
void script_begin(script *s);
void script_end(script *s);

// Raises an error if the running call's time is over.
void script_look(lua_State *L);

// A lua_Alloc.
void *script_allocate(void *data, void *at, size_t old_bytes, size_t bytes);

#endif
