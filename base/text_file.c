// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // memrchr
#include "base/text_file.h"

#include "base/budget.h"
#include "base/output.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

// NumPy's files begin with this byte, and hold any.
static const char NPY = '\x93';

// The first wrong byte ends the reading: a device may never end.
static bool check_text(const text *t, const char *block, size_t n, size_t *line, const char *path,
                       duet_error *err)
{
    size_t before = t->length - n;
    if (t->chars[0] == NPY)
        return true;
    const char *nul = memchr(block, '\0', n);
    if (nul)
        return bad_input(err, "%s: byte %zu is NUL, so this is no text", path,
                         before + (size_t)(nul - block));
    const char *end = memrchr(block, '\n', n);
    *line = end ? (size_t)(block + n - end) - 1 : *line + n;
    return *line <= TEXT_LINE_MOST ||
           bad_input(err, "%s: has a line of more than %d MiB, so this is no text", path,
                     TEXT_LINE_MOST >> 20);
}

// Bytes of a pipe may come late or never: Ctrl-C is heard meanwhile.
static size_t read_block(FILE *file, char *block, size_t size)
{
    enum { PATIENCE_MS = 100 };
    if (file != stdin)
        return fread(block, 1, size, file);
    struct pollfd in = {.fd = STDIN_FILENO, .events = POLLIN};
    while (poll(&in, 1, PATIENCE_MS) == 0)
        if (!budget_check_stop(NULL))
            return 0;
    ssize_t n = read(STDIN_FILENO, block, size);
    return n < 0 ? fread(block, 1, size, file) : (size_t)n; // which keeps the failure
}

// Devices as /dev/zero have no end.
static bool check_length(const text *t, const struct stat *info, const char *path, duet_error *err)
{
    enum { DEVICE_MOST = 1 << 28 };
    return !S_ISCHR(info->st_mode) || t->length <= DEVICE_MOST ||
           bad_input(err, "%s: a device with more than %d MiB; expected a file", path,
                     DEVICE_MOST >> 20);
}

// Ctrl-C ends the program that writes into a pipe as well, and maybe before it is heard here.
static bool check_end(const text *t, duet_error *err)
{
    const struct timespec moment = {.tv_nsec = 50000000};
    if (t->length == 0)
        nanosleep(&moment, NULL);
    return budget_check_stop(err);
}

static bool read_file(text *t, const char *path, bool is_text, duet_error *err)
{
    bool is_stdin = strcmp(path, "-") == 0;
    FILE *file = is_stdin ? stdin : fopen(path, "rb");
    if (!file)
        return error_set(err, errno == ENOENT ? DUET_STATUS_NOT_FOUND : DUET_STATUS_IO_FAILED,
                         "%s: %s", path, strerror(errno));
    struct stat info = {0};
    bool ok = true;
    path = is_stdin ? "stdin" : path;
    if (fstat(fileno(file), &info) == 0 && S_ISDIR(info.st_mode))
        ok = error_set(err, DUET_STATUS_IO_FAILED, "%s: is a folder, not a file", path);
    char block[65536];
    size_t n = 0;
    size_t line = 0;
    while (ok && (n = read_block(file, block, sizeof block)) > 0) {
        text_add_bytes(t, block, n);
        budget_tell(t->length, S_ISREG(info.st_mode) ? (uint64_t)info.st_size : 0);
        ok = text_ok(t, err) && check_length(t, &info, path, err) && budget_check(err) &&
             budget_space(t->length, err) &&
             (!is_text || check_text(t, block, n, &line, path, err));
    }
    ok = ok && (!is_stdin || check_end(t, err));
    if (ok && ferror(file))
        ok = error_set(err, DUET_STATUS_IO_FAILED, "%s: %s", path, strerror(errno));
    if (!is_stdin)
        fclose(file);
    text_add_bytes(t, "", 0);
    ok = ok && text_ok(t, err);
    if (!ok)
        text_free(t);
    return ok;
}

bool text_read_file(text *t, const char *path, duet_error *err)
{
    return read_file(t, path, false, err);
}

bool text_read_lines(text *t, const char *path, duet_error *err)
{
    return read_file(t, path, true, err);
}

bool text_check_magic(const text *t, const char magic[16], const char *path, duet_error *err)
{
    if (t->length >= 16 && memcmp(t->chars, magic, 16) == 0)
        return true;
    text shown = {0};
    size_t most = t->length < 16 ? t->length : 16;
    const char *end = most > 0 ? memchr(t->chars, '\n', most) : NULL;
    text_add_visible(&shown, t->chars, end ? (size_t)(end - t->chars) : most, "");
    bad_input(err, "%s: begins with \"%s\"; expected \"%.*s\"", path, text_chars(&shown),
              (int)strcspn(magic, "\n"), magic);
    text_free(&shown);
    return false;
}

bool text_write_file(const char *path, const char *bytes, size_t n, duet_error *err)
{
    output o;
    if (output_open(&o, path, err))
        fwrite(bytes, 1, n, o.stream); // a failure stays with the stream
    return output_close(&o, true, err);
}
