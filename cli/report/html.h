// SPDX-License-Identifier: MIT
// The parts of the page that `duet report` makes.
#ifndef CLI_REPORT_H
#define CLI_REPORT_H

#include "cli/report/bench_results.h"
#include "profiles/store.h"

// Profiles, how each was searched for, accuracy against time, and what became
// of them.
bool report_store(text *page, store *s, duet_error *err);

// The latest results: shares and stages; and all of them over time. Earlier
// results come first.
void report_bench(text *page, cJSON *const *results, uint32_t n);

// What levels of accuracy and effects cost: results of `duet accuracy` and of
// `duet explain --measure`.
void report_levels(text *page, const cJSON *const *results, uint32_t n);
void report_effects(text *page, const cJSON *const *results, uint32_t n);

#endif
