// SPDX-License-Identifier: MIT
// A private Lua state for text that a person wrote, with bounded memory,
// instructions and time. sandbox.h says what a script finds in it.
#ifndef GEN_SCRIPT_H
#define GEN_SCRIPT_H

#include "base/error.h"

#include <lua.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct script script;

typedef struct script_limits {
    size_t memory_bytes;   // the whole state's
    size_t host_bytes;     // the most that the host holds for it (base/budget.h); 0: any
    uint64_t instructions; // the most of one script_load, script_call or script_run
    double seconds;        // the most of one, too: few instructions can move many bytes
    duet_status failure;   // status of a script's error; 0: BAD_INPUT
} script_limits;

script_limits script_default_limits(void); // 64 MiB, 100 million, 10 s

// A state without any globals. limits may be NULL for the default ones. NULL with
// NO_MEMORY.
script *script_open(const script_limits *limits, duet_error *err);
void script_close(script *s);

// The state, to push arguments and read results. Whatever may raise or allocate
// there (lua_newtable, lua_pushstring, luaL_check...) belongs in a C function
// called through script_call: outside of one an error ends the process.
// lua_pushcfunction and lua_pushlightuserdata do neither.
lua_State *script_lua(script *s);

// Loads the text of a chunk and leaves it as a function on the stack. name is
// what messages call it: a file's path. limits.failure with name:line.
bool script_load(script *s, const char *name, const char *chars, size_t n, duet_error *err);

// Calls the function that lies under its n_args arguments; they give way to
// n_results results (or LUA_MULTRET), or to nothing on failure: limits.failure
// with file:line where the script raises an error or passes a limit.
bool script_call(script *s, int n_args, int n_results, duet_error *err);

// Both of the above, without arguments.
bool script_run(script *s, const char *name, const char *chars, size_t n, int n_results,
                duet_error *err);

// The text of the chunk loaded last, and its name, until the next is loaded; NULL if the state is
// none of a script's.
const char *script_chunk(lua_State *L, const char **name);

// Takes from what the running call has left; raises an error if that is not
// enough. C functions call it whose work a script can choose.
void script_spend(lua_State *L, uint64_t instructions);

// Ends the running call with NO_MEMORY. A C function calls it that gets none for what it reads.
void script_lacks_memory(lua_State *L);

// Makes the status that of the errors that follow, and returns the one before. A C function
// that finds text of its caller's wrong uses it; a script's own errors are limits.failure.
duet_status script_set_failure(lua_State *L, duet_status status);

// Pushes what tostring shows of the value at index. A table, function or
// userdata is shown by its kind and a number, in the order in which they were
// first shown: an address would be another one on each run.
const char *script_tostring(lua_State *L, int index, size_t *length);

#endif
