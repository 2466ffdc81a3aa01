// SPDX-License-Identifier: MIT
#include "cli/report/time_lines.h"

#include "cli/report/json.h"
#include "cli/report/rendering.h"

static const char *const parts[] = {"lua/timeline.lua", NULL};

// Lines of words below the title.
static void add_about(cJSON *o, const time_lines *shown)
{
    text lines = {0};
    const duet_plan *plan = shown->plan;
    text_add(&lines, "%.3f ms; share of A %.4g, grids: %s\n", shown->total_ms,
             plan->share / (double)DUET_SHARE_ONE, duet_mode_name(plan->mode));
    for (int i = 0; i < 2; ++i)
        text_add(&lines, "%c: %s, kernels '%s'\n", "AB"[i],
                 duet_device_pair_get_info(shown->pair, i) -> name,
                 i == 0 ? plan -> variant_a : plan -> variant_b);
    json_add_lines(o, "about", text_chars(&lines));
    text_free(&lines);
}

static cJSON *describe(const time_lines *shown)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("title", shown->title), NUMBER("total_ms", shown->total_ms));
    add_about(o, shown);
    cJSON *devices = cJSON_AddObjectToObject(o, "devices");
    json_add(devices, STRING("A", duet_device_pair_get_info(shown->pair, 0)->selector),
             STRING("B", duet_device_pair_get_info(shown->pair, 1)->selector));
    json_add_stages(o, shown->stages, shown->n_stages);
    return o;
}

bool time_lines_write(const time_lines *shown, const char *path, duet_error *err)
{
    cJSON *o = describe(shown);
    bool ok = rendering_write(path, parts, o, err);
    cJSON_Delete(o);
    return ok;
}
