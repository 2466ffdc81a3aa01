// SPDX-License-Identifier: MIT
// What `duet accuracy` tells of a scene that moves: a table, JSON, CSV, a plot.
#ifndef CLI_PACES_REPORT_H
#define CLI_PACES_REPORT_H

#include "tuner/cli/paces.h"

typedef struct paces_report {
    const duet_scene_info *scene;
    const duet_device_pair *pair;
    const paces *paces;
} paces_report;

void paces_report_text(const paces_report *r);
bool paces_report_json(const paces_report *r, duet_error *err);
bool paces_report_csv(const paces_report *r, const char *path, duet_error *err);

// A .svg or .png: the error over the time, with the front as a line.
bool paces_report_plot(const paces_report *r, const char *path, duet_error *err);

const char *pace_integrator(const pace *row);

#endif
