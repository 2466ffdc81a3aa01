// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "base/text.h"

#include <dirent.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

uint64_t test_seed(void)
{
    const char *given = getenv("DUET_TEST_SEED");
    uint64_t seed = given ? strtoull(given, NULL, 0) : 20261121;
    print_message("DUET_TEST_SEED=%" PRIu64 "\n", seed);
    return seed;
}

void test_write_file(const char *path, const char *content)
{
    duet_error err = {0};
    assert_ok(text_write_file(path, content, strlen(content), &err), err);
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
