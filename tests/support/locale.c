// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L // setenv
#include "support/locale.h"

#include "support/test.h"

#include <locale.h>
#include <unistd.h>

// Only numbers differ from "C".
static const char definition[] = "LC_NUMERIC\n"
                                 "decimal_point \"<U002C>\"\n"
                                 "thousands_sep \"<U002E>\"\n"
                                 "grouping 3;3\n"
                                 "END LC_NUMERIC\n";

void test_make_comma_locale(void)
{
    char folder[4096];
    assert_non_null(getcwd(folder, sizeof folder));
    test_write_file("comma.def", definition);
    // Says that the other categories are missing, which nobody needs, and that by its status.
    if (system("localedef --no-archive -c -i comma.def -f UTF-8 ./comma > comma.log 2>&1") == -1)
        abort();
    setenv("LOCPATH", folder, 1);
}

void test_speak_with_comma(bool comma)
{
    if (comma && !setlocale(LC_NUMERIC, "comma")) {
        print_message("no locale with a comma: localedef made none\n");
        skip();
    }
    if (!comma)
        setlocale(LC_NUMERIC, "C");
}
