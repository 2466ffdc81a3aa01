// SPDX-License-Identifier: MIT
// The path is taken part by part, each in the folder that the one before it
// opened, so that no link is followed on the way.
#define _GNU_SOURCE
#include "base/beneath.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// Steps from *folder into one part and closes what it stood in. false for a
// link, and for what cannot be told; *folder is -1 where there is nothing of
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
