// SPDX-License-Identifier: MIT
// A kept run of duet cluster as `duet profiles` tells it: as JSON, or to a person.
#ifndef CLI_CLUSTER_RUN_REPORT_H
#define CLI_CLUSTER_RUN_REPORT_H

#include "cli/report/json.h"
#include "profiles/cluster_run.h"

// All runs: prints them below a heading, with an empty line before it where `apart`, or, where
// `json` is given, adds "cluster_runs" to that. n, unless NULL, becomes their number.
bool cluster_run_report_list(store *s, bool apart, cJSON *json, uint64_t *n, duet_error *err);

// The run of this whole uid, with its ranks and its fabric.
bool cluster_run_report_show(store *s, const char *uid, bool json, duet_error *err);

#endif
