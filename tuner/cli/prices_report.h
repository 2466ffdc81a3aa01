// SPDX-License-Identifier: MIT
// What `duet accuracy` tells: a table, JSON, CSV, a plot.
#ifndef CLI_PRICES_REPORT_H
#define CLI_PRICES_REPORT_H

#include "tuner/cli/json.h"
#include "tuner/prices.h"

typedef struct prices_report {
    const duet_scene_info *scene;
    const duet_device_pair *pair;
    const prices *prices;
} prices_report;

void prices_report_text(const prices_report *r);
cJSON *prices_report_json(const prices_report *r);
bool prices_report_csv(const prices_report *r, const char *path, duet_error *err);

// A .svg or .png: for each device time and wrong pairs side by side.
bool prices_report_plot(const prices_report *r, const char *path, duet_error *err);

#define PRICES_TYPE "duet accuracy"

// BAD_INPUT where an object that is called that is none of ours.
bool prices_report_check(const cJSON *o, const char *path, duet_error *err);

#endif
