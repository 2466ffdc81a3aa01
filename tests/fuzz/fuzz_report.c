// SPDX-License-Identifier: MIT
// Results as JSON, as `duet report` and `duet bench --against` read them. An
// input may hold two results, one after a line "----".
#define _GNU_SOURCE
#include "support/fuzz.h"

#include "cli/commands.h"
#include "cli/report/bench_results.h"

#include <stdlib.h>
#include <string.h>

// The page must hold no markup but its own.
static void make_page(const char *first, const char *second)
{
    char page[192];
    strcpy(page, fuzz_place("page.html").chars);
    char *arguments[] = {"report", "-o", page, (char *)first, (char *)second, NULL};
    command_report(second ? 5 : 4, arguments);
}

static void compare(const char *first, const char *second)
{
    duet_error err = {0};
    cJSON *now = bench_read(first, &err);
    fuzz_require_answer(now != NULL, &err);
    err = (duet_error){0};
    cJSON *before = second ? bench_read(second, &err) : NULL;
    if (now && (before || !second)) {
        bench_compare(now, before);
        bench_tell(now, "s", before, NULL);
        bench_tell(now, NULL, before, NULL);
    }
    cJSON_Delete(now);
    cJSON_Delete(before);
}

void fuzz_one(const uint8_t *data, size_t n)
{
    static const char line[] = "\n----\n";
    const uint8_t *cut = memmem(data, n, line, strlen(line));
    size_t length = cut ? (size_t)(cut - data) : n;
    fuzz_path first = fuzz_file("first.json", data, length);
    fuzz_path second = {""};
    if (cut)
        second = fuzz_file("second.json", cut + strlen(line), n - length - strlen(line));
    setenv("DUET_PROFILE", fuzz_place("none.db").chars, 1);
    make_page(first.chars, cut ? second.chars : NULL);
    compare(first.chars, cut ? second.chars : NULL);
}
