// SPDX-License-Identifier: MIT
// A world under one plan, stepped again and again and timed.
#ifndef BENCH_SUBJECT_H
#define BENCH_SUBJECT_H

#include "runtime/duet.h"
#include "series.h"

enum { SUBJECT_STAGES = 16 };

typedef struct subject {
    duet_device_pair *pair;
    duet_world *world;
    duet_result last; // of the last step; its memory is the world's
    series total;     // wall clock of a step, ms
    series processors;
    struct {
        const char *name;
        series ms; // both devices together
    } stages[SUBJECT_STAGES];
    uint32_t n_stages;
} subject;

// The poses stay the caller's. variant is for both devices; share as in a plan.
bool subject_open(subject *s, const char *device_a, const char *device_b, uint32_t share,
                  const char *variant, const duet_pose *poses, uint32_t n, float cell,
                  duet_error *err);
void subject_close(subject *s);

// Steps once and keeps the times; false where the step fails.
bool subject_step(subject *s, duet_error *err);

// Steps once without keeping the times, so that kernels are built and memory
// is in place.
bool subject_warm_up(subject *s, duet_error *err);

void subject_print(const subject *s, const char *name); // one line: total and processors
void subject_print_stages(const subject *s);

#endif
