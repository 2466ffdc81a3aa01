// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "subject.h"

#include "runtime/broadphase/world.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static double process_cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static duet_plan plan_of(const subject_def *def)
{
    duet_plan plan = {.share = def->share, .mode = def->mode};
    snprintf(plan.variant_a, sizeof plan.variant_a, "%s", def->variant);
    snprintf(plan.variant_b, sizeof plan.variant_b, "%s", def->variant);
    return plan;
}

bool subject_open(subject *s, const subject_def *def, duet_error *err)
{
    *s = (subject){.def = *def};
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    pair_def.a = def->device_a;
    pair_def.b = def->device_b;
    s->pair = duet_device_pair_create(&pair_def, err);
    if (!s->pair)
        return false;
    duet_world_def world_def = duet_default_world_def();
    world_def.pair = s->pair;
    world_def.plan = plan_of(def);
    s->world = duet_world_create(&world_def, err);
    if (s->world && duet_world_set_objects(s->world, DUET_OBJECT_POSES, def->poses, def->n, err) &&
        duet_world_step(s->world, &s->last, err))
        return true;
    subject_close(s);
    return false;
}

void subject_close(subject *s)
{
    duet_world_destroy(s->world);
    duet_device_pair_destroy(s->pair);
    s->world = NULL;
    s->pair = NULL;
}

static int find_stage(subject *s, const char *name)
{
    for (uint32_t i = 0; i < s->n_stages; ++i)
        if (strcmp(s->stages[i].name, name) == 0)
            return (int)i;
    if (s->n_stages == SUBJECT_STAGES)
        return -1;
    s->stages[s->n_stages].name = name;
    return (int)s->n_stages++;
}

// A stage comes once for each device.
static void keep_stages(subject *s)
{
    double sums[SUBJECT_STAGES] = {0};
    for (uint32_t i = 0; i < s->last.n_stages; ++i) {
        int stage = find_stage(s, s->last.stages[i].name);
        if (stage >= 0)
            sums[stage] += s->last.stages[i].ms;
    }
    for (uint32_t k = 0; k < s->n_stages; ++k)
        series_add(&s->stages[k].ms, sums[k]);
}

static bool comes_after_grid(const char *stage)
{
    static const char *const names[] = {"candidates", "narrow", "search", "fetch pairs", "decide"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcmp(stage, names[i]) == 0)
            return true;
    return false;
}

static double search_ms(const duet_result *result)
{
    double ms[2] = {0};
    for (uint32_t i = 0; i < result->n_stages; ++i)
        if (comes_after_grid(result->stages[i].name))
            ms[result->stages[i].device] += result->stages[i].ms;
    return fmax(ms[0], ms[1]);
}

// Being timed by stages makes a GPU's step longer, so that is done apart.
static bool step_staged(subject *s, duet_error *err)
{
    s->world->def.stage_times = true;
    bool ok = duet_world_step(s->world, &s->last, err);
    s->world->def.stage_times = false;
    return ok;
}

bool subject_step(subject *s, duet_error *err)
{
    double cpu_begun = process_cpu_ms();
    if (!duet_world_step(s->world, &s->last, err))
        return false;
    series_add(&s->total, s->last.total_ms);
    series_add(&s->cpu, process_cpu_ms() - cpu_begun);
    if (!s->last.timed && !step_staged(s, err))
        return false;
    series_add(&s->searching, search_ms(&s->last));
    keep_stages(s);
    return true;
}

bool subjects_step(subject *subjects, uint32_t n, uint32_t runs, duet_error *err)
{
    for (uint32_t run = 0; run < runs; ++run)
        for (uint32_t i = 0; i < n; ++i)
            if (!subject_step(&subjects[i], err))
                return false;
    return true;
}

const series *subject_stage(const subject *s, const char *name)
{
    for (uint32_t i = 0; i < s->n_stages; ++i)
        if (strcmp(s->stages[i].name, name) == 0)
            return &s->stages[i].ms;
    return NULL;
}

void subject_print_head(void)
{
    printf("%-24s %9s %9s %9s %10s\n", "ms", "median", "least", "CPU time", "processors");
}

void subject_print_times(const char *name, const series *wall, const series *cpu)
{
    double ms = series_median(wall), cpu_ms = series_median(cpu);
    printf("%-24s %9.2f %9.2f %9.2f %10.2f\n", name, ms, series_least(wall), cpu_ms, cpu_ms / ms);
}

void subject_print(const subject *s)
{
    subject_print_times(s->def.name, &s->total, &s->cpu);
}

void subject_print_stages(const subject *s)
{
    for (uint32_t i = 0; i < s->n_stages; ++i)
        printf("  %-22s %9.2f %9.2f\n", s->stages[i].name, series_median(&s->stages[i].ms),
               series_least(&s->stages[i].ms));
}
