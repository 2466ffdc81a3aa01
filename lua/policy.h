// SPDX-License-Identifier: MIT
// What a script may do with the machine through this module. `duet lua` sets
// it for scripts that nobody vouches for; everywhere else all is allowed.
#ifndef LUA_POLICY_H
#define LUA_POLICY_H

#include <lua.h>
#include <stdbool.h>

// From here on the state's scripts change no file, choose no kernel text, and
// read only the named paths and what lies below the current folder.
void policy_restrict(lua_State *L, const char *const *paths, int n_paths);

// Both raise an error that names --trust.
void policy_check_read(lua_State *L, const char *path);
void policy_check_trusted(lua_State *L, const char *what);

// Whether a path stays below the current folder: false for one that begins at the
// root, has a part "..", or goes through or to a link, wherever that leads. A
// path that does not exist leads nowhere.
bool path_is_beneath(const char *path);

#endif
