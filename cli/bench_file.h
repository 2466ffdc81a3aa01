// SPDX-License-Identifier: MIT
// Results of `duet bench` as JSON: one object a file, with the devices and an
// object for each case. docs/formats.md has the fields.
#ifndef CLI_BENCH_FILE_H
#define CLI_BENCH_FILE_H

#include "cli/report/json.h"
#include "cli/timed.h"

enum { BENCH_SAMPLES_MOST = 512 };

cJSON *bench_begin(const duet_device_pair *pair, bool quick);

// Adds what was measured by the plan, or why that failed; returns the case.
cJSON *bench_add(cJSON *results, const duet_scene_info *scene, const duet_plan *plan,
                 const timed *t, const duet_error *failure);

#define BENCH_TYPE "duet bench"

// BAD_INPUT names the file, the case and the field that is not as it must be.
bool bench_check(const cJSON *o, const char *path, duet_error *err);
cJSON *bench_read(const char *path, duet_error *err);

// The case that was measured on the same scene by the same plan, or NULL.
const cJSON *bench_find(const cJSON *results, const cJSON *like);

// samples_ms of a case; returns how many.
uint32_t bench_samples(const cJSON *one, double samples[BENCH_SAMPLES_MOST]);

#endif
