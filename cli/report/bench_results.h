// SPDX-License-Identifier: MIT
// Results of `duet bench` as JSON: one object a file, with the devices and an
// object for each case. docs/formats.md has the fields. And what a person is told of
// them: a table for each scene, next to earlier results if there are some.
#ifndef CLI_BENCH_RESULTS_H
#define CLI_BENCH_RESULTS_H

#include "cli/report/json.h"
#include "cli/timed.h"

enum { BENCH_SAMPLES_MOST = 512, BENCH_NAME = 512 };

cJSON *bench_begin(const duet_device_pair *pair, bool quick);

// A scene or a task that is measured.
typedef struct bench_subject {
    const char *name;
    uint32_t dims;    // 0: it is a task
    uint64_t objects; // or items of a task
} bench_subject;

// Adds what was measured by the plan, or why that failed; returns the case.
cJSON *bench_add(cJSON *results, const bench_subject *subject, const duet_plan *plan,
                 const timed *t, const duet_error *failure);

#define BENCH_TYPE "duet bench"

// BAD_INPUT names the file, the case and the field that is not as it must be.
bool bench_check(const cJSON *o, const char *path, duet_error *err);
cJSON *bench_read(const char *path, duet_error *err);

// Prints the cases of one scene, or with NULL how many cases became faster, stayed the same and so
// on. before: what bench_read gave, or NULL.
bool bench_tell(const cJSON *results, const char *scene, const cJSON *before, duet_error *err);

// The first case of verdict "slower", as one line names it: "paper by 'simd', mode own,
// share 0.50". False if there is none; n counts them.
bool bench_first_slower(const cJSON *results, char name[BENCH_NAME], uint32_t *n);

// Adds to each case how it compares: against_ms, ratio, ratio_low, ratio_high
// (above 1: faster now) and verdict. Nothing if before is NULL.
void bench_compare(cJSON *results, const cJSON *before);

#endif
