// SPDX-License-Identifier: MIT
// duet profiles list: the profiles by device pair and size, and the runs of clusters.
#include "cli/commands/profiles.h"
#include "cli/report/profile_report.h"
#include "cli/report/rendering.h"

static bool list_entry(void *context, const profile_entry *e)
{
    cJSON *o = profile_report_json(e);
    json_add(o, NUMBER("pair_id", e->row.pair_id));
    return cJSON_AddItemToArray(context, o);
}

static bool count_entry(void *context, const profile_entry *e)
{
    *(uint64_t *)context += e->dead_reason != NULL;
    return true;
}

bool profiles_list(store *s, bool dead, bool json, duet_error *err)
{
    uint64_t n_dead = 0;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("store", store_path(s)));
    cJSON *profiles = cJSON_AddArrayToObject(o, "profiles");
    bool ok = profile_entry_each(s, NULL, dead, list_entry, profiles, err) &&
              (json || cJSON_GetArraySize(profiles) > 0 ||
               profile_entry_each(s, NULL, true, count_entry, &n_dead, err));
    if (!json)
        json_add(o, NUMBER("dead", n_dead));
    if (ok)
        return rendering_tell(o, json, "cli/report/profiles.lua", err);
    cJSON_Delete(o);
    return false;
}
