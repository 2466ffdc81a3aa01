// SPDX-License-Identifier: MIT
// Whole profile stores, SQLite's files, as a stranger may send them: looked in as
// an application does at its start, listed, reported, written out, and upgraded.
#include "support/fuzz.h"
#include "support/store.h"

#include "cli/report/page.h"
#include "profiles/duet_profiles.h"
#include "profiles/lookup.h"
#include "runtime/duet.h"

#include <stdio.h>

static void look(const char *path)
{
    profile_request request = test_usual_request(1000);
    profile_found found;
    text why = {0};
    duet_error err = {0};
    bool ok = profile_lookup_files(path, NULL, &request, &found, &why, &err);
    fuzz_require_answer(ok, &err);
    fuzz_require(found.grade <= PROFILE_DEFAULT);
    fuzz_require(found.grade == PROFILE_DEFAULT || found.plan.share <= PROFILE_SHARE_ONE);
    text_free(&why);
}

static void list(const char *path)
{
    duet_error err = {0};
    duet_profile_list *all = duet_profile_list_create(path, true, &err);
    fuzz_require_answer(all != NULL, &err);
    for (uint32_t i = 0; all && i < duet_profile_list_get_count(all); ++i) {
        duet_stored_trial *trials = NULL;
        uint32_t n = 0;
        err = (duet_error){0};
        bool ok = duet_profile_get_trials(path, duet_profile_list_get_profile(all, i)->uid, &trials,
                                          &n, &err);
        fuzz_require_answer(ok, &err);
        duet_free(trials);
    }
    duet_profile_list_destroy(all);
}

static void report(const char *path)
{
    duet_error err = {0};
    cJSON *files, *shown = page_begin(&files);
    store *s = store_open(path, STORE_READ, &err);
    fuzz_require_answer(s != NULL, &err);
    if (s)
        fuzz_require_answer(page_add_store(shown, s, &err) &&
                                page_write(fuzz_place("page.html").chars, shown, &err),
                            &err);
    cJSON_Delete(shown);
    store_close(s);
}

static void change(const char *path)
{
    duet_error err = {0};
    store *s = store_open(path, STORE_WRITE, &err);
    fuzz_require_answer(s != NULL, &err);
    store_close(s);
    err = (duet_error){0};
    fuzz_require_answer(duet_profiles_export(path, fuzz_place("rows.jsonl").chars, &err), &err);
}

static void forget(const char *path)
{
    static const char *const beside[] = {"-wal", "-shm", "-journal", ".v1"};
    for (size_t i = 0; i < sizeof beside / sizeof beside[0]; ++i) {
        char name[256];
        snprintf(name, sizeof name, "%s%s", path, beside[i]);
        remove(name);
    }
}

void fuzz_one(const uint8_t *data, size_t n)
{
    fuzz_path path = fuzz_file("profiles.db", data, n);
    look(path.chars);
    list(path.chars);
    report(path.chars);
    change(path.chars);
    forget(path.chars);
}
