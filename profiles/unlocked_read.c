// SPDX-License-Identifier: MIT
// A writer leaves a trace that a reader can see afterwards: a side file with
// something in it, or another time of the file itself. File times tick coarsely,
// so a file that changed a moment ago does not count as resting.
#define _POSIX_C_SOURCE 200809L
#include "profiles/unlocked_read.h"

#include "base/clock.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

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

static bool is_same(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino && a->st_size == b->st_size &&
           changed_ns(a) == changed_ns(b);
}

static unlocked_read unlocked_read_look(const char *path)
{
    unlocked_read q = {0};
    q.holds = stat(path, &q.seen) == 0 && !unlocked_read_has_side_file(path) &&
              llabs(clock_calendar_ns() - changed_ns(&q.seen)) > SETTLED_NS;
    return q;
}

bool unlocked_read_holds(const char *path, const unlocked_read *before)
{
    unlocked_read after = unlocked_read_look(path);
    return before->holds && after.holds && is_same(&before->seen, &after.seen);
}

bool unlocked_read_has_side_file(const char *path)
{
    return has_side_file(path, "-wal") || has_side_file(path, "-journal");
}

unlocked_read unlocked_read_begin(const char *path)
{
    enum { WAIT_MS = 10, MAX_WAITS = SETTLED_NS / 1000000 / WAIT_MS + 1 };
    unlocked_read q = unlocked_read_look(path);
    struct stat info;
    for (int i = 0;
         !q.holds && i < MAX_WAITS && stat(path, &info) == 0 && !unlocked_read_has_side_file(path);
         ++i) {
        nanosleep(&(struct timespec){.tv_nsec = WAIT_MS * 1000000}, NULL);
        q = unlocked_read_look(path);
    }
    return q;
}

bool unlocked_read_check(const char *path, const unlocked_read *before, duet_error *err)
{
    unlocked_read after = {0};
    return !before->holds ||
           (stat(path, &after.seen) == 0 && is_same(&before->seen, &after.seen)) ||
           error_set(err, DUET_STATUS_STORE_FAILED,
                     "%s: was written while it was read; run the command again", path);
}

void unlocked_read_uri(const char *path, text *uri)
{
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789/._-";
    text_add(uri, "file:%s", *path == '/' ? "//" : "./");
    for (const char *c = path; *c; ++c)
        text_add(uri, strchr(plain, *c) ? "%c" : "%%%02X", (unsigned char)*c);
    text_add(uri, "?immutable=1");
}
