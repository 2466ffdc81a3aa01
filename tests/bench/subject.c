// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "subject.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

static double process_cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

bool subject_open(subject *s, const char *device_a, const char *device_b, uint32_t share,
                  const char *variant, const duet_pose *poses, uint32_t n, float cell,
                  duet_error *err)
{
    *s = (subject){0};
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    pair_def.a = device_a;
    pair_def.b = device_b;
    s->pair = duet_device_pair_open(&pair_def, err);
    if (!s->pair)
        return false;
    duet_world_def def = duet_default_world_def();
    def.pair = s->pair;
    def.plan = duet_default_plan(s->pair);
    def.plan.share = share;
    snprintf(def.plan.variant_a, sizeof def.plan.variant_a, "%s", variant);
    snprintf(def.plan.variant_b, sizeof def.plan.variant_b, "%s", variant);
    def.cell = cell;
    s->world = duet_world_create(&def, err);
    if (s->world && duet_world_set_poses(s->world, poses, n, err))
        return true;
    subject_close(s);
    return false;
}

void subject_close(subject *s)
{
    duet_world_destroy(s->world);
    duet_device_pair_close(s->pair);
    s->world = NULL;
    s->pair = NULL;
}

static series *stage_series(subject *s, const char *name)
{
    for (uint32_t i = 0; i < s->n_stages; ++i)
        if (strcmp(s->stages[i].name, name) == 0)
            return &s->stages[i].ms;
    if (s->n_stages == SUBJECT_STAGES)
        return NULL;
    s->stages[s->n_stages].name = name;
    return &s->stages[s->n_stages++].ms;
}

// A stage's time on one device may come in several rows.
static void keep_stages(subject *s)
{
    double sums[SUBJECT_STAGES] = {0};
    for (uint32_t i = 0; i < s->last.n_stages; ++i) {
        series *kept = stage_series(s, s->last.stages[i].name);
        for (uint32_t k = 0; k < s->n_stages; ++k)
            if (kept == &s->stages[k].ms)
                sums[k] += s->last.stages[i].ms;
    }
    for (uint32_t k = 0; k < s->n_stages; ++k)
        series_add(&s->stages[k].ms, sums[k]);
}

bool subject_warm_up(subject *s, duet_error *err)
{
    return duet_world_step(s->world, &s->last, err);
}

bool subject_step(subject *s, duet_error *err)
{
    double cpu_begun = process_cpu_ms();
    if (!duet_world_step(s->world, &s->last, err))
        return false;
    series_add(&s->total, s->last.total_ms);
    series_add(&s->processors, (process_cpu_ms() - cpu_begun) / s->last.total_ms);
    keep_stages(s);
    return true;
}

void subject_print(const subject *s, const char *name)
{
    printf("%-24s %9.2f %9.2f %6.2f\n", name, series_median(&s->total), series_least(&s->total),
           series_median(&s->processors));
}

void subject_print_stages(const subject *s)
{
    for (uint32_t i = 0; i < s->n_stages; ++i)
        printf("  %-22s %9.2f %9.2f\n", s->stages[i].name, series_median(&s->stages[i].ms),
               series_least(&s->stages[i].ms));
}
