// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "lua/policy.h"

#include <errno.h>
#include <fcntl.h>
#include <lauxlib.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// ---------------------------------------------------------------- paths

// The path is taken part by part, each in the folder that the one before it
// opened, so that no link is followed on the way.

// Steps from *folder into one part and closes what it stood in. false for a
// link, and for what cannot be told; *folder is -1 if there is nothing of
// that name.
static bool step(int *folder, const char *part)
{
    struct stat info;
    int next = openat(*folder, part, O_PATH | O_NOFOLLOW | O_CLOEXEC);
    bool straight = next >= 0 ? fstat(next, &info) == 0 && !S_ISLNK(info.st_mode)
                              : errno == ENOENT || errno == ENOTDIR;
    if (*folder != AT_FDCWD)
        close(*folder);
    *folder = next;
    return straight;
}

static bool goes_straight(const char *path)
{
    char part[NAME_MAX + 1];
    int folder = AT_FDCWD;
    bool ok = true;
    while (ok && *path && (folder >= 0 || folder == AT_FDCWD)) {
        size_t n = strcspn(path, "/");
        ok = n < sizeof part;
        if (ok && n > 0) {
            memcpy(part, path, n);
            part[n] = '\0';
            ok = step(&folder, part);
        }
        path += n + (path[n] == '/');
    }
    if (folder >= 0)
        close(folder);
    return ok;
}

static bool has_part_up(const char *path)
{
    for (const char *part = path; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || part[2] == '\0'))
            return true;
    }
    return false;
}

bool path_is_beneath(const char *path)
{
    return *path != '/' && !has_part_up(path) && goes_straight(path);
}

// ---------------------------------------------------------------- policy

// In the registry: nil if all is allowed, else the set of named paths.
static const char key = 0;

void policy_restrict(lua_State *L, const char *const *paths, int n_paths)
{
    lua_newtable(L);
    for (int i = 0; i < n_paths; ++i) {
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, paths[i]);
    }
    lua_rawsetp(L, LUA_REGISTRYINDEX, &key);
}

void policy_check_read(lua_State *L, const char *path)
{
    int allowed = 1;
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &key) != LUA_TNIL) {
        lua_getfield(L, -1, path);
        allowed = lua_toboolean(L, -1) || (strcmp(path, "-") != 0 && path_is_beneath(path));
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    if (!allowed)
        luaL_error(L,
                   "'%s' is not below the current folder, or a link: name it on the command "
                   "line, or give --trust",
                   path);
}

void policy_check_trusted(lua_State *L, const char *what)
{
    int restricted = lua_rawgetp(L, LUA_REGISTRYINDEX, &key) != LUA_TNIL;
    lua_pop(L, 1);
    if (restricted)
        luaL_error(L, "%s needs 'duet lua --trust'", what);
}
