// SPDX-License-Identifier: MIT
// `duet tune` tells this: a line while it measures, a row for each workload, and at the
// end what the shares are worth. The rows are kept as the JSON that --json prints; the
// table reads them back.
#ifndef CLI_TUNE_REPORT_H
#define CLI_TUNE_REPORT_H

#include "cli/report/json.h"
#include "tuner/duet_tune.h"

typedef struct tune_report {
    cJSON *workloads; // one object each
    char name[168];   // the measured workload's
    const duet_tune_def *def;
    uint64_t items;  // its query has, or its task
    uint32_t number; // from 1
    uint32_t n_workloads;
    char whole[80]; // the device that A and B may be parts of
    bool one;       // A and B are the same device
    double budget_seconds;
    const char *store_path; // the value of --profile, or NULL
    bool json;
    bool on_terminal;
    bool waits; // told so last
} tune_report;

tune_report tune_report_begin(bool json, const char *store_path);

// Says what is to come, for the line while it measures. budget_seconds is of each
// workload; 0: no limit.
void tune_report_expect(tune_report *r, const duet_device_pair *pair, uint32_t n_workloads,
                        double budget_seconds);

// The workload that is measured next; the def is borrowed until the next one.
void tune_report_workload(tune_report *r, const duet_tune_def *def);

// A duet_tune_watch; stops after Ctrl-C.
bool tune_report_watch(void *report, const duet_tune_progress *p);

// Adds the outcome of that workload. command runs it, and the plan is added to it here; it is
// empty for a query, which no command runs.
void tune_report_add(tune_report *r, const duet_tune_outcome *o, text *command);

// Prints the table, or the object. After a failure only the table, of what was
// done before.
bool tune_report_end(tune_report *r, bool ok, duet_error *err);

#endif
