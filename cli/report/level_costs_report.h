// SPDX-License-Identifier: MIT
// `duet accuracy` tells this of a still scene.
#ifndef CLI_LEVEL_COSTS_REPORT_H
#define CLI_LEVEL_COSTS_REPORT_H

#include "cli/report/json.h"
#include "tuner/level_costs.h"

// Measures each device alone, with a progress line; Ctrl-C ends it with the whole
// rounds until then.
bool level_costs_show(level_costs *p, duet_device_pair *pair, const duet_scene *scene,
                      uint32_t rounds, duet_error *err);

cJSON *level_costs_report_json(const level_costs *p, const duet_scene_info *scene,
                               const duet_device_pair *pair);

#define LEVEL_COSTS_TYPE "duet accuracy"

// BAD_INPUT if an object that is called that is none of ours.
bool level_costs_report_check(const cJSON *o, const char *path, duet_error *err);

#endif
