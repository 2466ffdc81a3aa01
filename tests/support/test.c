// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "base/text_file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pty.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static uint64_t seed_of_run(void)
{
    const char *given = getenv("DUET_TEST_SEED");
    return given ? strtoull(given, NULL, 0) : 20261121;
}

uint64_t test_seed(void)
{
    uint64_t seed = seed_of_run();
    print_message("DUET_TEST_SEED=%" PRIu64 "\n", seed);
    return seed;
}

static bool takes_all;

void test_take_all(void)
{
    takes_all = true;
}

void test_begin(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--all") == 0)
        test_take_all();
}

bool test_takes(uint64_t way, unsigned of)
{
    return takes_all || (way + seed_of_run()) % of == 0;
}

void test_write_file(const char *path, const char *content)
{
    duet_error err = {0};
    assert_ok(text_write_file(path, content, strlen(content), &err), err);
}

void skip_without_device(const char *path)
{
    int file = open(path, O_RDWR | O_CLOEXEC);
    if (file >= 0) {
        close(file);
        return;
    }
    print_message("%s cannot be opened here: %s; skipped\n", path, strerror(errno));
    skip();
}

void skip_without_terminal(void)
{
    int ends[2];
    if (openpty(&ends[0], &ends[1], NULL, NULL, NULL) == 0) {
        close(ends[0]);
        close(ends[1]);
        return;
    }
    print_message("no pseudo terminal can be opened here: %s; skipped\n", strerror(errno));
    skip();
}

int test_count_files(void)
{
    int n = 0;
    DIR *names = opendir(".");
    assert_non_null(names);
    for (const struct dirent *e = readdir(names); e; e = readdir(names))
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(names);
    return n;
}
