// SPDX-License-Identifier: MIT
// What `duet bench` tells a person: a table for each scene, next to earlier
// results where there are some.
#ifndef CLI_BENCH_REPORT_H
#define CLI_BENCH_REPORT_H

#include "cli/bench_file.h"

// The cases of one scene; before is NULL or what bench_read gave.
void bench_print_scene(const cJSON *results, const char *scene, const cJSON *before);

// How many cases became faster, stayed the same and so on; nothing where
// before is NULL.
void bench_print_verdicts(const cJSON *results, const cJSON *before);

// Adds to each case how it compares: against_ms, ratio, ratio_low, ratio_high
// (above 1: faster now) and verdict. Nothing where before is NULL.
void bench_compare(cJSON *results, const cJSON *before);

#endif
