// SPDX-License-Identifier: MIT
#include "subject.h"

#include "runtime/broadphase/world.h"

static duet_plan plan_of(const subject_def *def)
{
    duet_plan plan = {.share = def->share, .mode = def->mode};
    snprintf(plan.variant_a, sizeof plan.variant_a, "%s", def->variant);
    snprintf(plan.variant_b, sizeof plan.variant_b, "%s", def->variant);
    return plan;
}

subject *subject_open(subject_def def)
{
    subject *s = bench_alloc(sizeof *s);
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    duet_world_def world_def = duet_default_world_def();
    pair_def.a = def.device_a;
    pair_def.b = def.device_b;
    world_def.plan = plan_of(&def);
    s->def = def;
    s->pair = must(duet_device_pair_create(&pair_def, ERR));
    s->world = bench_world(s->pair, world_def);
    must(duet_world_set_objects(s->world, DUET_OBJECT_POSES, def.poses, def.n, ERR));
    must(duet_world_step(s->world, &s->last, ERR));
    return s;
}

subject *subject_alone(const bench_options *options, const char *kernels, const duet_pose *poses,
                       uint32_t n)
{
    return subject_open((subject_def){.name = kernels,
                                      .device_a = options->device,
                                      .device_b = options->device,
                                      .variant = kernels,
                                      .mode = DUET_MODE_OWN,
                                      .poses = poses,
                                      .n = n});
}

void subject_close(subject *s)
{
    duet_world_destroy(s->world);
    duet_device_pair_destroy(s->pair);
    free(s);
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
static void step_staged(subject *s)
{
    s->world->def.stage_times = true;
    must(duet_world_step(s->world, &s->last, ERR));
    s->world->def.stage_times = false;
}

void subject_step(subject *s)
{
    double cpu_begun = bench_cpu_ms();
    must(duet_world_step(s->world, &s->last, ERR));
    series_add(&s->total, s->last.total_ms);
    series_add(&s->cpu, bench_cpu_ms() - cpu_begun);
    if (!s->last.timed)
        step_staged(s);
    series_add(&s->searching, search_ms(&s->last));
    keep_stages(s);
}

void subjects_step(subject *const *subjects, uint32_t n, uint32_t runs)
{
    for (uint32_t run = 0; run < runs; ++run)
        for (uint32_t i = 0; i < n; ++i)
            subject_step(subjects[i]);
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

void subject_print_stage(const char *name, const series *ms)
{
    printf("  %-22s %9.2f %9.2f\n", name, series_median(ms), series_least(ms));
}

void subject_print_stages(const subject *s)
{
    for (uint32_t i = 0; i < s->n_stages; ++i)
        subject_print_stage(s->stages[i].name, &s->stages[i].ms);
}
