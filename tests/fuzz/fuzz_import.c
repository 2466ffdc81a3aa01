// SPDX-License-Identifier: MIT
// Profiles as JSON lines. Lines that were taken in go out again as JSON, and comes
// into an empty store as it went out.
#define _POSIX_C_SOURCE 200809L
#include "support/fuzz.h"

#include "base/text_file.h"
#include "profiles/exchange.h"
#include "profiles/profile.h"
#include "profiles/profile_view.h"
#include "profiles/upkeep.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

static bool import(store *s, const char *lines, size_t n, uint64_t *added)
{
    duet_error err = {0};
    profile_import_counts counts;
    FILE *in = fmemopen((void *)lines, n, "r");
    fuzz_require(in);
    bool ok = profile_import(s, in, "rows.jsonl", &counts, &err);
    fclose(in);
    fuzz_require_answer(ok, &err);
    *added = counts.added;
    return ok;
}

static void require_json(const char *lines)
{
    const char *end = NULL;
    for (const char *at = lines; *at; at = end + 1) {
        cJSON *row = cJSON_ParseWithOpts(at, &end, false);
        fuzz_require(cJSON_IsObject(row) && *end == '\n');
        cJSON_Delete(row);
    }
}

static char *export_lines(store *s)
{
    duet_error err = {0};
    char *lines = NULL;
    size_t n = 0;
    FILE *out = open_memstream(&lines, &n);
    fuzz_require(out);
    fuzz_require(profile_export(s, out, "memory", &err));
    fclose(out);
    require_json(lines);
    return lines;
}

static void read_all(store *s)
{
    duet_error err = {0};
    uint32_t problems = 0;
    cJSON *shown = cJSON_CreateArray();
    text report = {0};
    fuzz_require_answer(profile_view_add(s, "", true, "", shown, &err), &err);
    fuzz_require_answer(profile_check(s, &report, &problems, &err), &err);
    cJSON_Delete(shown);
    text_free(&report);
}

static store *open_store(const char *path)
{
    duet_error err = {0};
    store *s = store_open(path, STORE_WRITE, &err);
    fuzz_require(s);
    return s;
}

// A store without rows. Made once and copied, which is quicker.
static store *open_empty(const char *name)
{
    static text empty;
    duet_error err = {0};
    if (!empty.chars) {
        fuzz_path made = fuzz_place("empty.db");
        store_close(open_store(made.chars));
        fuzz_require(text_read_file(&empty, made.chars, &err));
    }
    return open_store(fuzz_file(name, (const uint8_t *)empty.chars, empty.length).chars);
}

static store *tried;

void fuzz_begin(void)
{
    tried = open_empty("tried.db");
}

// Whether rows come in at all; most inputs end here, and nothing is kept.
static bool adds_rows(const char *lines, size_t n)
{
    duet_error err = {0};
    uint64_t added = 0;
    fuzz_require(store_begin(tried, &err));
    bool ok = n > 0 && import(tried, lines, n, &added);
    store_end(tried, false, NULL);
    return ok && added > 0;
}

// Gives what a store that took the lines exports; the caller frees it.
static char *pass_through(const char *name, const char *lines, size_t n)
{
    uint64_t added = 0;
    store *s = open_empty(name);
    fuzz_require(import(s, lines, n, &added) && added > 0);
    read_all(s);
    char *out = export_lines(s);
    store_close(s);
    return out;
}

void fuzz_one(const uint8_t *data, size_t n)
{
    if (!adds_rows((const char *)data, n))
        return;
    char *lines = pass_through("first.db", (const char *)data, n);
    char *again = pass_through("second.db", lines, strlen(lines));
    fuzz_require(strcmp(lines, again) == 0);
    free(lines);
    free(again);
}
