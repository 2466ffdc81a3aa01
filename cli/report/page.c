// SPDX-License-Identifier: MIT
#include "cli/report/page.h"

#include "base/text.h"
#include "cli/report/profile_report.h"
#include "cli/report/rendering.h"
#include "runtime/duet.h"

#include <time.h>

// Each part of the script takes what the one before it returns; the last returns the page's
// function.
static const char *const parts[] = {"cli/report/read.lua",       "cli/report/page_draw.lua",
                                    "cli/report/page_store.lua", "cli/report/page_bench.lua",
                                    "cli/report/page.lua",       NULL};

cJSON *page_begin(void)
{
    char when[40];
    time_t now = time(NULL);
    strftime(when, sizeof when, "%Y-%m-%d %H:%M UTC", gmtime(&now));
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("made", when), STRING("duet", duet_version()));
    cJSON_AddArrayToObject(o, "levels");
    cJSON_AddArrayToObject(o, "effects");
    cJSON_AddArrayToObject(o, "bench");
    return o;
}

// ---------------------------------------------------------------- the store

typedef struct gathering {
    store *s;
    cJSON *profiles;
    bool ok;
    duet_error *err;
} gathering;

static bool gather(void *context, const profile_entry *e)
{
    gathering *g = context;
    cJSON *o = profile_report_json(e);
    json_add(o, NUMBER("pair_id", e->row.pair_id), NUMBER("workload_id", e->row.workload_id),
             NUMBER("created_ns", e->created_ns));
    cJSON_AddItemToArray(g->profiles, o);
    g->ok = e->dead_reason || profile_report_add_trials(o, g->s, e->session.id, g->err);
    return g->ok;
}

bool page_add_store(cJSON *shown, store *s, duet_error *err)
{
    cJSON *o = cJSON_AddObjectToObject(shown, "store");
    json_add(o, STRING("path", store_path(s)));
    gathering g = {s, cJSON_AddArrayToObject(o, "profiles"), true, err};
    return profile_entry_each(s, NULL, true, gather, &g, err) && g.ok;
}

bool page_make(text *page, const cJSON *shown, duet_error *err)
{
    return rendering_make(page, parts, shown, err);
}
