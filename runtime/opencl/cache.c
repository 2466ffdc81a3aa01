// SPDX-License-Identifier: MIT
// An entry is one line, then the binary:
//
//   duet program 1 KEY LENGTH SHA-256
//
// A reader writes the line again from what follows it and compares the two, so
// that nothing in a file is believed.
//
// The folder is opened once, and both it and what is read in it are looked at
// when they are open: a name that changes meanwhile leads nowhere else.
#define _GNU_SOURCE
#include "runtime/opencl/cache.h"

#include "base/error.h"
#include "base/output.h"
#include "base/text.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

// With its NUL, so that "ab" + "c" is not "a" + "bc".
static void hash_string(SHA2_CTX *hash, const char *chars)
{
    SHA256Update(hash, (const uint8_t *)chars, strlen(chars) + 1);
}

void cache_key(const char *source, const char *build_options, const duet_device_info *device,
               char key[65])
{
    SHA2_CTX hash;
    SHA256Init(&hash);
    hash_string(&hash, source);
    hash_string(&hash, build_options);
    hash_string(&hash, device->name);
    hash_string(&hash, device->vendor);
    hash_string(&hash, device->driver);
    hash_string(&hash, device->cl_version);
    hash_string(&hash, device->platform);
    hash_string(&hash, device->platform_version);
    SHA256End(&hash, key);
}

static void name_entry(char name[80], const char *key)
{
    snprintf(name, 80, "%s.bin", key);
}

static void add_line(text *line, const char *key, const char *bytes, size_t n)
{
    char sum[65];
    SHA256Data((const uint8_t *)bytes, n, sum);
    text_add(line, "duet program 1 %s %zu %s\n", key, n, sum);
}

// ------------------------------------------------------------------- whose it is

// A program is code, which nobody but this user may have put here.
static const char *what_is_wrong(const struct stat *info)
{
    if (info->st_uid != geteuid())
        return "belongs to another user";
    return info->st_mode & (S_IWGRP | S_IWOTH) ? "can be written by other users" : NULL;
}

static bool refuse(const char *dir, const char *why, duet_error *err)
{
    return bad_argument(err,
                        "%s: %s, so that built kernels are not safe there; name a folder that only "
                        "you can write, with DUET_CACHE say",
                        dir, why);
}

// The folder, looked at once it is open, so that nothing can be put in its
// place between. -1 where there is none that may be used; err is set only where
// it is somebody else's.
static int open_folder(const char *dir, duet_error *err)
{
    struct stat info;
    int folder = open(dir, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) {
        if (lstat(dir, &info) == 0 && S_ISLNK(info.st_mode))
            refuse(dir, "is a link", err);
        return -1;
    }
    const char *why = fstat(folder, &info) == 0 ? what_is_wrong(&info) : "cannot be looked at";
    if (!why)
        return folder;
    refuse(dir, why, err);
    close(folder);
    return -1;
}

bool cache_check(const char *dir, duet_error *err)
{
    duet_error why = {0};
    int folder = open_folder(dir, &why);
    if (folder >= 0)
        close(folder);
    return why.status == DUET_STATUS_OK || error_copy(err, &why);
}

static void make_folder(const char *dir)
{
    char above[4096];
    const char *end = strrchr(dir, '/');
    if (mkdir(dir, 0700) == 0 || errno != ENOENT || !end || end == dir ||
        (size_t)(end - dir) >= sizeof above)
        return;
    snprintf(above, sizeof above, "%.*s", (int)(end - dir), dir);
    mkdir(above, 0700);
    mkdir(dir, 0700);
}

bool cache_check_writable(const char *dir, duet_error *err)
{
    make_folder(dir);
    duet_error why = {0};
    int folder = open_folder(dir, &why);
    bool writable = folder >= 0 && faccessat(folder, ".", W_OK, AT_EACCESS) == 0;
    const char *reason = strerror(errno);
    if (folder >= 0)
        close(folder);
    if (why.status != DUET_STATUS_OK)
        return error_copy(err, &why);
    return writable || bad_argument(err, "built kernels cannot be kept in %s: %s", dir, reason);
}

// ------------------------------------------------------------------- entries

static bool read_all(text *entry, int file)
{
    char block[65536];
    ssize_t n = 0;
    while ((n = read(file, block, sizeof block)) > 0)
        text_add_bytes(entry, block, (size_t)n);
    text_add_bytes(entry, "", 0);
    return n == 0 && text_ok(entry, NULL);
}

// O_NONBLOCK, so that a pipe does not make it wait.
static bool read_entry(text *entry, int folder, const char *key)
{
    char name[80];
    name_entry(name, key);
    int file = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    struct stat info;
    bool read = file >= 0 && fstat(file, &info) == 0 && S_ISREG(info.st_mode) &&
                !what_is_wrong(&info) && read_all(entry, file);
    if (read)
        futimens(file, NULL); // it was used
    if (file >= 0)
        close(file);
    return read;
}

// Takes the line off the entry where it is the right one.
static bool open_entry(text *entry, const char *key)
{
    const char *end = memchr(entry->chars, '\n', entry->length);
    if (!end)
        return false;
    size_t begin = (size_t)(end + 1 - entry->chars);
    text line = {0};
    add_line(&line, key, entry->chars + begin, entry->length - begin);
    bool right =
        !line.failed && line.length == begin && memcmp(line.chars, entry->chars, begin) == 0;
    text_free(&line);
    entry->length -= begin;
    memmove(entry->chars, entry->chars + begin, entry->length + 1);
    return right;
}

bool cache_get(const char *dir, const char key[65], text *binary)
{
    int folder = open_folder(dir, NULL);
    bool found = folder >= 0 && read_entry(binary, folder, key) && open_entry(binary, key);
    if (folder >= 0)
        close(folder);
    if (!found)
        text_free(binary);
    return found;
}

// Anything but a plain file, such as a link, makes space for the entry.
static void make_room(int folder, const char *name)
{
    struct stat info;
    if (fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) == 0 && !S_ISREG(info.st_mode))
        unlinkat(folder, name, 0);
}

typedef struct entry_file {
    char name[80];
    uint64_t bytes;
    struct timespec used;
} entry_file;

static int by_use(const void *a, const void *b)
{
    const struct timespec *x = &((const entry_file *)a)->used, *y = &((const entry_file *)b)->used;
    if (x->tv_sec != y->tv_sec)
        return x->tv_sec < y->tv_sec ? -1 : 1;
    return x->tv_nsec < y->tv_nsec ? -1 : x->tv_nsec > y->tv_nsec;
}

// Whether the name is an entry's. Files that a killed process left half-written are removed.
static bool note_entry(int folder, const char *name, entry_file *file)
{
    enum { WRITTEN_BY_THEN_S = 3600 };
    struct stat info;
    if (fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(info.st_mode))
        return false;
    if (text_ends_with(name, ".part") && time(NULL) - info.st_mtime > WRITTEN_BY_THEN_S)
        unlinkat(folder, name, 0);
    if (!text_ends_with(name, ".bin") || strlen(name) >= sizeof file->name)
        return false;
    snprintf(file->name, sizeof file->name, "%s", name);
    file->bytes = (uint64_t)info.st_size;
    file->used = info.st_mtim;
    return true;
}

// How many entries there are; none without memory.
static size_t look_through(int folder, entry_file **files)
{
    struct dirent **found = NULL;
    int n_found = scandirat(folder, ".", &found, NULL, NULL);
    size_t n = 0;
    *files = n_found > 0 ? calloc((size_t)n_found, sizeof **files) : NULL;
    for (int i = 0; i < n_found; ++i) {
        n += *files && note_entry(folder, found[i]->d_name, &(*files)[n]);
        free(found[i]);
    }
    free(found);
    return n;
}

// A quarter goes at once, so that not every new entry has to look for another to go.
static void sweep(int folder)
{
    entry_file *files = NULL;
    size_t n = look_through(folder, &files);
    uint64_t bytes = 0;
    for (size_t i = 0; i < n; ++i)
        bytes += files[i].bytes;
    if (bytes > CACHE_MOST_BYTES)
        qsort(files, n, sizeof *files, by_use);
    uint64_t most = bytes > CACHE_MOST_BYTES ? CACHE_MOST_BYTES / 4 * 3 : CACHE_MOST_BYTES;
    for (size_t i = 0; i < n && bytes > most; ++i) {
        unlinkat(folder, files[i].name, 0);
        bytes -= files[i].bytes;
    }
    free(files);
}

bool cache_put(const char *dir, const char key[65], const char *bytes, size_t n)
{
    make_folder(dir);
    int folder = open_folder(dir, NULL);
    if (folder < 0)
        return false;
    char name[80];
    name_entry(name, key);
    make_room(folder, name);
    sweep(folder);
    text entry = {0};
    add_line(&entry, key, bytes, n);
    text_add_bytes(&entry, bytes, n);
    output o;
    if (output_open_in(&o, folder, name, 0600, NULL))
        fwrite(text_chars(&entry), 1, entry.length, o.stream);
    bool kept = output_close(&o, text_ok(&entry, NULL), NULL);
    text_free(&entry);
    return kept;
}
