// SPDX-License-Identifier: MIT
// A writer leaves a trace that a reader can see afterwards: a side file with
// something in it, or another time of the file itself. File times tick coarsely,
// so a file that changed a moment ago does not count as resting.
#define _POSIX_C_SOURCE 200809L
#include "profiles/quiet.h"

#include "runtime/base/clock.h"

#include <stdlib.h>
#include <string.h>

#define SETTLED_NS 50000000

static bool has_side_file(const char *path, const char *ending)
{
    text name = {0};
    struct stat info;
    text_add(&name, "%s%s", path, ending);
    bool there = !text_ok(&name, NULL) || (stat(name.chars, &info) == 0 && info.st_size > 0);
    text_free(&name);
    return there;
}

static int64_t changed_ns(const struct stat *info)
{
    return (int64_t)info->st_mtim.tv_sec * 1000000000 + info->st_mtim.tv_nsec;
}

quiet quiet_look(const char *path)
{
    quiet q = {0};
    q.holds = stat(path, &q.seen) == 0 && !has_side_file(path, "-wal") &&
              !has_side_file(path, "-journal") &&
              llabs(clock_calendar_ns() - changed_ns(&q.seen)) > SETTLED_NS;
    return q;
}

bool quiet_still(const char *path, const quiet *before)
{
    quiet after = quiet_look(path);
    return before->holds && after.holds && after.seen.st_ino == before->seen.st_ino &&
           after.seen.st_size == before->seen.st_size &&
           changed_ns(&after.seen) == changed_ns(&before->seen);
}

void quiet_name(const char *path, text *uri)
{
    text_add(uri, "file:");
    for (const char *c = path; *c; ++c)
        text_add(uri, strchr("%?#", *c) ? "%%%02X" : "%c", (unsigned char)*c);
    text_add(uri, "?immutable=1");
}
