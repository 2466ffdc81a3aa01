// SPDX-License-Identifier: MIT
// An entry is one line, then the binary:
//
//   duet program 1 KEY LENGTH SHA-256
//
// A reader writes the line again from what follows it and compares the two, so
// that nothing in a file is believed.
#define _POSIX_C_SOURCE 200809L
#include "runtime/cache.h"

#include <sha256.h>
#include <string.h>
#include <sys/stat.h>
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

static void add_path(text *path, const char *dir, const char *key)
{
    text_add(path, "%s/%s.bin", dir, key);
}

static void add_line(text *line, const char *key, const char *bytes, size_t n)
{
    char sum[65];
    SHA256Data((const uint8_t *)bytes, n, sum);
    text_add(line, "duet program 1 %s %zu %s\n", key, n, sum);
}

// A program is code: only a plain file of this user or of root is read.
static bool is_ours(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode) &&
           (info.st_uid == geteuid() || info.st_uid == 0);
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
    text path = {0};
    add_path(&path, dir, key);
    bool found = !path.failed && is_ours(path.chars) && text_read_file(binary, path.chars, NULL) &&
                 open_entry(binary, key);
    text_free(&path);
    if (!found)
        text_free(binary);
    return found;
}

// A link, which may lead anywhere, makes room for the entry.
static void remove_link(const char *path)
{
    struct stat info;
    if (lstat(path, &info) == 0 && S_ISLNK(info.st_mode))
        unlink(path);
}

bool cache_put(const char *dir, const char key[65], const char *bytes, size_t n)
{
    text path = {0}, entry = {0};
    add_path(&path, dir, key);
    add_line(&entry, key, bytes, n);
    text_add_bytes(&entry, bytes, n);
    mkdir(dir, 0700);
    if (!path.failed)
        remove_link(path.chars);
    bool kept = !path.failed && !entry.failed &&
                text_write_file(path.chars, entry.chars, entry.length, NULL);
    text_free(&path);
    text_free(&entry);
    return kept;
}
