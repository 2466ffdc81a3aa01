// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L // newlocale
#include "base/plain_numbers.h"

#include <langinfo.h>
#include <locale.h>
#include <stddef.h>

// All of "C", and not its numbers alone: that takes no memory, so it cannot fail.
void *plain_numbers_begin(void)
{
    const char *point = nl_langinfo(RADIXCHAR);
    return point[0] == '.' && !point[1] ? NULL
                                        : uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
}

void plain_numbers_end(void *before)
{
    if (before)
        freelocale(uselocale(before));
}
