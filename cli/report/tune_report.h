// SPDX-License-Identifier: MIT
// What `duet tune` shows: a line while it measures, a row for each workload,
// and at the end what the shares are worth.
#ifndef CLI_TUNE_REPORT_H
#define CLI_TUNE_REPORT_H

#include "tuner/duet_tune.h"

struct cJSON;

typedef struct tune_report {
    struct cJSON *workloads; // one object each
    char name[168];          // of the workload that is measured
    bool json;
    bool on_terminal;
} tune_report;

tune_report tune_report_begin(bool json);
void tune_report_workload(tune_report *r, const duet_scene_info *scene);

// A duet_tune_watch with the report as context; stops after Ctrl-C.
bool tune_report_watch(void *report, const duet_tune_progress *progress);

void tune_report_add(tune_report *r, const duet_tune_outcome *outcome);

// Prints the table, or the object. After a failure only the table, of what was
// done before.
bool tune_report_end(tune_report *r, bool ok, duet_error *err);

#endif
