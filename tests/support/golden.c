// SPDX-License-Identifier: MIT
#include "support/golden.h"
#include "support/test.h"

#include "base/text_file.h"

static void compare_lines(const char *path, const char *got, const char *wanted)
{
    for (int line = 1;; ++line) {
        size_t n_got = strcspn(got, "\n");
        size_t n_wanted = strcspn(wanted, "\n");
        if (n_got != n_wanted || memcmp(got, wanted, n_got) != 0)
            fail_msg("%s:%d: is '%.*s', was '%.*s'", path, line, (int)n_got, got, (int)n_wanted,
                     wanted);
        if (got[n_got] != wanted[n_wanted])
            fail_msg("%s:%d: only one of the texts ends here", path, line);
        if (!got[n_got])
            return;
        got += n_got + 1;
        wanted += n_wanted + 1;
    }
}

void golden_check(const char *name, const char *chars)
{
    own(text) path = {0}, wanted = {0};
    text_add(&path, "%s/../golden/%s", getenv("DUET_TEST_DATA"), name);
    if (getenv("DUET_UPDATE_GOLDEN"))
        must(text_write_file(path.chars, chars, strlen(chars), ERR));
    must(text_read_file(&wanted, path.chars, ERR));
    compare_lines(path.chars, chars, wanted.chars);
}
