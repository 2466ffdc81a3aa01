// SPDX-License-Identifier: MIT
// What an application does at its start: a look into two files.
#include "profiles/lookup.h"

#include "profiles/sql.h"

static bool look_once(const char *path, const profile_request *request, profile_found *found,
                      text *why, bool *disturbed, duet_error *err)
{
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    store *s = store_open_look(path, err);
    bool ok = s && profile_lookup(s, request, found, why, err);
    *disturbed = s && !store_undisturbed(s);
    store_close(s);
    return ok;
}

// A writer that came in between may have shown half of its work, so the look
// is taken again; then it is seen to write, and read in step with it.
static bool look_in_file(const char *path, const profile_request *request, profile_found *found,
                         text *why, duet_error *err)
{
    enum { MAX_LOOKS = 3 };
    for (int i = 0;; ++i) {
        text told = {0};
        duet_error failure = {0};
        bool disturbed = false;
        bool ok = look_once(path, request, found, why ? &told : NULL, &disturbed, &failure);
        bool final = !disturbed || i == MAX_LOOKS;
        if (final && !ok)
            error_set(err, failure.status, "%s", failure.text);
        if (final && why)
            text_add(why, "%s%s%s", ok ? path : failure.text, ok ? ":\n" : "\n", text_chars(&told));
        text_free(&told);
        if (final)
            return ok;
    }
}

bool profile_lookup_files(const char *user_path, const char *system_path,
                          const profile_request *request, profile_found *found, text *why,
                          duet_error *err)
{
    const char *paths[] = {user_path, system_path};
    bool ok = true;
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    for (int i = 0; i < 2 && found->grade != PROFILE_EXACT; ++i) {
        profile_found here;
        duet_error failure = {0};
        if (!paths[i])
            continue;
        if (!look_in_file(paths[i], request, &here, why, &failure) &&
            failure.status != DUET_STATUS_NOT_FOUND)
            ok = error_set(err, failure.status, "%s", failure.text);
        if (here.grade < found->grade)
            *found = here;
    }
    return ok && (!why || text_ok(why, err));
}
