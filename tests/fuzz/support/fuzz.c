// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/fuzz.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char folder[128];

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *at)
{
    (void)info;
    (void)type;
    (void)at;
    return remove(path);
}

static void remove_folder(void)
{
    nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

const char *fuzz_folder(void)
{
    if (folder[0])
        return folder;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/duet_fuzz.XXXXXX", parent ? parent : "/tmp");
    fuzz_require(mkdtemp(folder));
    atexit(remove_folder);
    return folder;
}

fuzz_path fuzz_place(const char *name)
{
    fuzz_path path;
    snprintf(path.chars, sizeof path.chars, "%s/%s", fuzz_folder(), name);
    return path;
}

fuzz_path fuzz_file(const char *name, const uint8_t *data, size_t n)
{
    fuzz_path path = fuzz_place(name);
    FILE *file = fopen(path.chars, "wb");
    fuzz_require(file);
    fuzz_require(fwrite(data, 1, n, file) == n);
    fuzz_require(fclose(file) == 0);
    return path;
}

void fuzz_require_at(bool holds, const char *fact, const char *file, int line)
{
    if (holds)
        return;
    printf("%s:%d: does not hold: %s\n", file, line, fact);
    fflush(stdout);
    abort();
}

void fuzz_require_answer(bool ok, const duet_error *err)
{
    fuzz_require(ok == (err->status == DUET_STATUS_OK));
    fuzz_require(ok == (err->text[0] == '\0'));
    fuzz_require(!strpbrk(err->text, "\n\r"));
}
