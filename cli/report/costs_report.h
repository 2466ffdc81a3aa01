// SPDX-License-Identifier: MIT
// What `duet explain` tells: a table, JSON.
#ifndef CLI_COSTS_REPORT_H
#define CLI_COSTS_REPORT_H

#include "cli/costs.h"
#include "cli/report/json.h"

void costs_report_text(const costs *c);
cJSON *costs_report_json(const costs *c, const duet_scene_info *scene,
                         const duet_device_pair *pair);

#define COSTS_TYPE "duet explain"

// BAD_INPUT where an object that is called that is none of ours, with costs.
bool costs_report_check(const cJSON *o, const char *path, duet_error *err);

#endif
