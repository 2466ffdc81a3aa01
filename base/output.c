// SPDX-License-Identifier: MIT
// The temporary name is random and made with O_EXCL, so that nobody who may
// write in the folder can put a link in its way.
#define _GNU_SOURCE
#include "base/output.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_LINKS = 40, MAX_TRIES = 16 };

static bool fail(const output *o, int code, duet_error *err)
{
    return error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be written: %s", text_chars(&o->path),
                     strerror(code));
}

// ------------------------------------------------------------------- the place

static const char *last_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void add_folder(text *folder, const char *path)
{
    size_t n = (size_t)(last_name(path) - path);
    text_add(folder, "%.*s", n > 0 ? (int)n : 2, n > 0 ? path : "./");
}

static bool is_same(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

// The number of /dev/fd/3 or /proc/self/fd/3; -1 for every other path. Such a
// descriptor is used itself: opened anew it would begin at the file's start.
static int own_descriptor(const char *path)
{
    text folder = {0};
    struct stat here, own;
    char *end = NULL;
    long number = strtol(last_name(path), &end, 10);
    add_folder(&folder, path);
    bool is_own = end > last_name(path) && *end == '\0' && text_ok(&folder, NULL) &&
                  stat("/proc/self/fd", &own) == 0 && stat(folder.chars, &here) == 0 &&
                  is_same(&own, &here);
    text_free(&folder);
    return is_own ? (int)number : -1;
}

// Takes one link at the path's end. false if there is none.
static bool follow_link(text *path)
{
    char to[4096];
    ssize_t n = readlink(path->chars, to, sizeof to - 1);
    if (n < 0)
        return false;
    to[n] = '\0';
    text next = {0};
    if (to[0] != '/')
        add_folder(&next, path->chars);
    text_add(&next, "%s", to);
    text_free(path);
    *path = next;
    return !path->failed;
}

// ------------------------------------------------------------------- half-written files

enum { MAX_PARTS = 32, MAX_NAME = 256, FREE = 0, TAKEN, WRITTEN };

// The temporary names of all outputs that are open. A name is random, so that removing one
// that is there no more removes nothing else.
static struct {
    _Atomic int state; // FREE, TAKEN or WRITTEN
    int folder;
    char name[MAX_NAME];
} parts[MAX_PARTS];

static int enter_part(int folder, const char *name)
{
    for (int i = 0; i < MAX_PARTS; ++i) {
        int expected = FREE;
        if (!atomic_compare_exchange_strong(&parts[i].state, &expected, TAKEN))
            continue;
        parts[i].folder = folder;
        snprintf(parts[i].name, sizeof parts[i].name, "%s", name);
        atomic_store(&parts[i].state, WRITTEN);
        return i;
    }
    return -1;
}

static void leave_part(output *o)
{
    if (o->slot >= 0)
        atomic_store(&parts[o->slot].state, FREE);
    o->slot = -1;
}

void output_remove_parts(void)
{
    for (int i = 0; i < MAX_PARTS; ++i)
        if (atomic_load(&parts[i].state) == WRITTEN)
            unlinkat(parts[i].folder, parts[i].name, 0);
}

int output_watch_part(const char *path)
{
    text folder = {0};
    add_folder(&folder, path);
    int file = text_ok(&folder, NULL) ? open(folder.chars, O_PATH | O_DIRECTORY | O_CLOEXEC) : -1;
    int slot = file >= 0 ? enter_part(file, last_name(path)) : -1;
    if (slot < 0 && file >= 0)
        close(file);
    text_free(&folder);
    return slot;
}

void output_forget_part(int slot)
{
    if (slot < 0)
        return;
    int folder = parts[slot].folder;
    atomic_store(&parts[slot].state, FREE);
    close(folder);
}

// ------------------------------------------------------------------- opening

static bool take_stream(output *o, int file, duet_error *err)
{
    o->stream = file >= 0 ? fdopen(file, "w") : NULL;
    if (o->stream)
        return true;
    fail(o, errno, err);
    if (file >= 0)
        close(file);
    return false;
}

static bool open_directly(output *o, const char *place, duet_error *err)
{
    return take_stream(o, open(place, O_WRONLY | O_NOFOLLOW | O_NOCTTY | O_CLOEXEC), err);
}

// The name is cut so that, with what is added, it stays within the longest name of a file.
static bool name_part(output *o)
{
    uint64_t random = 0;
    text_free(&o->part);
    text_add(&o->part, "%.200s", text_chars(&o->name));
    if (getentropy(&random, sizeof random) != 0)
        return false;
    text_add(&o->part, ".%016" PRIx64 ".part", random);
    return text_ok(&o->part, NULL);
}

static bool open_part(output *o, mode_t mode, duet_error *err)
{
    int file = -1;
    errno = EEXIST;
    for (int i = 0; file < 0 && errno == EEXIST && i < MAX_TRIES && name_part(o); ++i) {
        leave_part(o);
        o->slot = enter_part(o->folder, text_chars(&o->part));
        file = openat(o->folder, o->part.chars,
                      O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
    }
    if (file < 0)
        text_free(&o->part);
    return take_stream(o, file, err);
}

bool output_open_in(output *o, int folder, const char *name, mode_t mode, duet_error *err)
{
    *o = (output){.folder = folder, .slot = -1};
    text_add(&o->path, "%s", name);
    text_add(&o->name, "%s", name);
    return text_ok(&o->path, err) && text_ok(&o->name, err) && open_part(o, mode, err);
}

static bool open_beside(output *o, const char *place, duet_error *err)
{
    text folder = {0};
    add_folder(&folder, place);
    text_add(&o->name, "%s", last_name(place));
    if (text_ok(&folder, err) && text_ok(&o->name, err)) {
        o->folder = open(folder.chars, O_PATH | O_DIRECTORY | O_CLOEXEC);
        if (o->folder < 0)
            fail(o, errno, err);
    }
    text_free(&folder);
    return o->folder >= 0 && open_part(o, 0666, err);
}

static bool open_place(output *o, const char *place, duet_error *err)
{
    struct stat info;
    bool there = lstat(place, &info) == 0;
    if (!there && errno != ENOENT)
        return fail(o, errno, err);
    if (!*last_name(place) || (there && S_ISDIR(info.st_mode)))
        return fail(o, *place ? EISDIR : ENOENT, err);
    if (there && S_ISLNK(info.st_mode))
        return fail(o, ELOOP, err);
    return there && !S_ISREG(info.st_mode) ? open_directly(o, place, err)
                                           : open_beside(o, place, err);
}

static bool open_stdout(output *o, duet_error *err)
{
    fflush(stdout);
    return take_stream(o, fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0), err);
}

// Follows the links at a path's end to the place that is written, or to a descriptor.
static int find_place(const char *path, text *place)
{
    text_add(place, "%s", path);
    int own = own_descriptor(path);
    for (int i = 0; own < 0 && i < MAX_LINKS && text_ok(place, NULL) && follow_link(place); ++i)
        own = own_descriptor(place->chars);
    return own;
}

bool output_open(output *o, const char *path, duet_error *err)
{
    text place = {0};
    *o = (output){.folder = -1, .slot = -1};
    bool is_stdout = strcmp(path, "-") == 0;
    text_add(&o->path, "%s", is_stdout ? "stdout" : path);
    if (is_stdout)
        return text_ok(&o->path, err) && open_stdout(o, err);
    int own = find_place(path, &place);
    bool ok = text_ok(&place, err) && text_ok(&o->path, err);
    ok = ok && (own >= 0 ? take_stream(o, fcntl(own, F_DUPFD_CLOEXEC, 0), err)
                         : open_place(o, place.chars, err));
    text_free(&place);
    return ok;
}

bool output_part_path(const output *o, text *path, duet_error *err)
{
    char link[64];
    char folder[4096];
    if (o->folder < 0)
        return error_set(err, DUET_STATUS_IO_FAILED,
                         "%s: cannot be written by several ranks; expected a plain file",
                         text_chars(&o->path));
    snprintf(link, sizeof link, "/proc/self/fd/%d", o->folder);
    ssize_t n = readlink(link, folder, sizeof folder);
    if (n < 0 || (size_t)n == sizeof folder)
        return fail(o, n < 0 ? errno : ENAMETOOLONG, err);
    text_add_bytes(path, folder, (size_t)n);
    text_add(path, "/%s", text_chars(&o->part));
    return text_ok(path, err);
}

// ------------------------------------------------------------------- closing

// Renaming takes the place of a plain file or of nothing, and of nothing else.
static bool put_in_place(const output *o, duet_error *err)
{
    struct stat info;
    const char *name = o->name.chars;
    if (fstatat(o->folder, name, &info, AT_SYMLINK_NOFOLLOW) == 0 && !S_ISREG(info.st_mode))
        return fail(o, S_ISDIR(info.st_mode) ? EISDIR : EEXIST, err);
    return renameat(o->folder, o->part.chars, o->folder, name) == 0 || fail(o, errno, err);
}

static bool close_stream(output *o, bool keep, duet_error *err)
{
    if (!o->stream)
        return false;
    bool written = !ferror(o->stream) && fflush(o->stream) == 0;
    int code = errno; // error of this write, or of the one that failed before
    if (fclose(o->stream) != 0 && written) {
        written = false;
        code = errno;
    }
    return keep && (written || fail(o, code, err));
}

// A pipe or a device knows no disk.
bool output_sync(output *o, duet_error *err)
{
    if (!o->stream || fflush(o->stream) != 0) // which output_close tells
        return true;
    return fsync(fileno(o->stream)) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP ||
           fail(o, errno, err);
}

bool output_close(output *o, bool keep, duet_error *err)
{
    bool kept = close_stream(o, keep, err);
    if (o->folder >= 0) {
        kept = kept && put_in_place(o, err);
        if (!kept && o->part.length > 0)
            unlinkat(o->folder, o->part.chars, 0);
        leave_part(o);
        close(o->folder);
    }
    text_free(&o->path);
    text_free(&o->name);
    text_free(&o->part);
    *o = (output){.folder = -1, .slot = -1};
    return kept;
}

bool output_make_folders(const char *path, mode_t mode, text *failed)
{
    text folder = {0};
    text_add(&folder, "%s", path);
    bool ok = text_ok(&folder, NULL);
    int code = ok ? 0 : ENOMEM;
    for (char *at = ok ? strchr(folder.chars + 1, '/') : NULL; ok && at; at = strchr(at + 1, '/')) {
        *at = '\0';
        ok = mkdir(folder.chars, mode) == 0 || errno == EEXIST;
        code = errno;
        if (!ok && failed)
            text_add(failed, "%s", folder.chars);
        *at = '/';
    }
    text_free(&folder);
    errno = code;
    return ok;
}

// Compares two names that no file has.
static bool is_same_new_place(const char *a, const char *b)
{
    text places[2] = {{0}}, folders[2] = {{0}};
    const char *paths[2] = {a, b};
    struct stat info[2];
    bool ok = true;
    for (int i = 0; i < 2; ++i) {
        ok = find_place(paths[i], &places[i]) < 0 && text_ok(&places[i], NULL) && ok;
        add_folder(&folders[i], text_chars(&places[i]));
        ok = ok && text_ok(&folders[i], NULL) && stat(folders[i].chars, &info[i]) == 0;
    }
    ok = ok && is_same(&info[0], &info[1]) &&
         strcmp(last_name(places[0].chars), last_name(places[1].chars)) == 0;
    for (int i = 0; i < 2; ++i) {
        text_free(&places[i]);
        text_free(&folders[i]);
    }
    return ok;
}

bool output_replaces(const char *read_or_written, const char *path)
{
    struct stat first, second;
    if (strcmp(path, "-") == 0)
        return false;
    bool is_stdin = strcmp(read_or_written, "-") == 0;
    bool is_there = (is_stdin ? fstat(STDIN_FILENO, &first) : stat(read_or_written, &first)) == 0;
    if (is_there)
        return S_ISREG(first.st_mode) && stat(path, &second) == 0 && is_same(&first, &second);
    return !is_stdin && stat(path, &second) != 0 && is_same_new_place(read_or_written, path);
}

// A pipe or device that may be written. Opening one may wait for a reader, or wind a tape.
static bool passes_unopened(const char *path)
{
    text place = {0};
    struct stat there;
    bool passes = find_place(path, &place) < 0 && stat(path, &there) == 0 &&
                  (S_ISFIFO(there.st_mode) || S_ISCHR(there.st_mode) || S_ISBLK(there.st_mode)) &&
                  faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) == 0;
    text_free(&place);
    return passes;
}

bool output_check(const char *path, duet_error *err)
{
    output o;
    if (strcmp(path, "-") == 0 || passes_unopened(path))
        return true;
    bool ok = output_open(&o, path, err);
    output_close(&o, false, NULL);
    return ok;
}
