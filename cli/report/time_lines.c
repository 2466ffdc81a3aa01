// SPDX-License-Identifier: MIT
#include "cli/report/time_lines.h"

#include "cli/report/json.h"
#include "cli/report/rendering.h"

static const char *const parts[] = {"lua/timeline.lua", NULL};

// Lines of words below the title.
static void add_about(cJSON *o, const duet_device_pair *pair, const duet_plan *plan,
                      double total_ms)
{
    text lines = {0};
    text_add(&lines, "%.3f ms; share of A %.4g, grids: %s\n", total_ms,
             plan->share / (double)DUET_SHARE_ONE, duet_mode_name(plan->mode));
    for (int i = 0; i < 2; ++i)
        text_add(&lines, "%c: %s, kernels '%s'\n", "AB"[i],
                 duet_device_pair_get_info(pair, i) -> name,
                 i == 0 ? plan -> variant_a : plan -> variant_b);
    json_add_lines(o, "about", text_chars(&lines));
    text_free(&lines);
}

bool time_lines_write(const char *path, const char *title, const duet_device_pair *pair,
                      const duet_plan *plan, const timed_step *step, duet_error *err)
{
    if (!path)
        return true;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("title", title), NUMBER("total_ms", step->total_ms));
    add_about(o, pair, plan, step->total_ms);
    cJSON *devices = cJSON_AddObjectToObject(o, "devices");
    json_add(devices, STRING("A", duet_device_pair_get_info(pair, 0)->selector),
             STRING("B", duet_device_pair_get_info(pair, 1)->selector));
    json_add_stages(o, step->stages, step->n_stages);
    bool ok = rendering_write(path, parts, o, err);
    cJSON_Delete(o);
    return ok;
}
