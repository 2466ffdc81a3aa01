// SPDX-License-Identifier: MIT
#include "cli/report/page.h"

#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "profiles/profile_view.h"
#include "runtime/duet.h"

#include <time.h>

// Each part of the script takes what the one before it returns; the last returns the page's
// function.
static const char *const parts[] = {"cli/report/read.lua",       "cli/report/page_draw.lua",
                                    "cli/report/page_store.lua", "cli/report/page_bench.lua",
                                    "cli/report/page.lua",       NULL};

cJSON *page_begin(cJSON **files)
{
    char when[40];
    time_t now = time(NULL);
    strftime(when, sizeof when, "%Y-%m-%d %H:%M UTC", gmtime(&now));
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("made", when), STRING("duet", duet_version()));
    *files = cJSON_AddArrayToObject(o, "files");
    return o;
}

// ---------------------------------------------------------------- the store

bool page_add_store(cJSON *shown, store *s, duet_error *err)
{
    cJSON *o = cJSON_AddObjectToObject(shown, "store");
    json_add(o, STRING("path", store_path(s)));
    cJSON *profiles = cJSON_AddArrayToObject(o, "profiles"), *one;
    bool ok =
        profile_view_add(s, "", true, ", p.pair_id, p.workload_id, p.created_ns", profiles, err);
    cJSON_ArrayForEach(one, profiles)
    {
        bool is_live = cJSON_IsTrue(cJSON_GetObjectItem(one, "live"));
        ok = ok && (!is_live || profile_view_add_trials(s, json_string(one, "uid"), one, err));
    }
    return ok;
}

bool page_write(const char *path, const cJSON *shown, duet_error *err)
{
    return rendering_write(path, parts, shown, err);
}
