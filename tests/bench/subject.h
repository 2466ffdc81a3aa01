// SPDX-License-Identifier: MIT
// A world under one plan, stepped again and again and timed.
#ifndef BENCH_SUBJECT_H
#define BENCH_SUBJECT_H

#include "bench.h"

enum { SUBJECT_STAGES = 16 };

typedef struct subject_def {
    const char *name;
    const char *device_a; // selectors; NULL for both: the default device pair
    const char *device_b;
    const char *variant; // kernels of both devices
    duet_mode mode;
    uint32_t share; // the share as in a plan
    const duet_pose *poses;
    uint32_t n;
} subject_def;

typedef struct subject {
    subject_def def;
    duet_device_pair *pair;
    duet_world *world;
    duet_result last; // result of the last step; its memory is the world's
    series total;     // wall clock of a step, ms
    series searching; // the longer of the devices' times after the grid, ms
    series cpu;       // CPU time of all threads, ms
    struct {
        const char *name;
        series ms; // both devices together
    } stages[SUBJECT_STAGES];
    uint32_t n_stages;
} subject;

// The poses stay the caller's. Steps once, so that kernels are built and memory
// is in place.
subject *subject_open(subject_def def);
// On the one device of the options, by these kernels.
subject *subject_alone(const bench_options *options, const char *kernels, const duet_pose *poses,
                       uint32_t n);
void subject_close(subject *s);

// Steps once and keeps the times.
void subject_step(subject *s);

// Steps each of them in turn, so many times.
void subjects_step(subject *const *subjects, uint32_t n, uint32_t runs);

// The stage's samples; NULL where the subject has no such stage.
const series *subject_stage(const subject *s, const char *name);

// One line: wall clock, CPU time and their ratio, the processors.
void subject_print_head(void);
void subject_print(const subject *s);
void subject_print_times(const char *name, const series *wall, const series *cpu);
void subject_print_stage(const char *name, const series *ms);
void subject_print_stages(const subject *s);

#endif
