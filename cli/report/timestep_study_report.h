// SPDX-License-Identifier: MIT
// What `duet accuracy` tells of a scene that moves: a table, JSON, CSV, a plot.
#ifndef CLI_TIMESTEP_STUDY_REPORT_H
#define CLI_TIMESTEP_STUDY_REPORT_H

#include "cli/timestep_study.h"

typedef struct timestep_study_report {
    const duet_scene_info *scene;
    const duet_device_pair *pair;
    const timestep_study *study;
} timestep_study_report;

void timestep_study_report_text(const timestep_study_report *r);
bool timestep_study_report_json(const timestep_study_report *r, duet_error *err);
bool timestep_study_report_csv(const timestep_study_report *r, const char *path, duet_error *err);

// A .svg or .png: the error over the time, with the front as a line.
bool timestep_study_report_plot(const timestep_study_report *r, const char *path, duet_error *err);

const char *timestep_integrator(const timestep_run *row);

#endif
