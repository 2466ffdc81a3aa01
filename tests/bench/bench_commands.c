// SPDX-License-Identifier: MIT
// What commands cost: columns of cubes sleep, and before each step a hundredth of all are removed
// and others put in their places; beside it the same bodies are only woken, and with them those
// that they lay on, which lose their load where bodies are removed.
#include "bench.h"

#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { HIGH = 4, EACH = 25, SETTLING = 60 };

typedef enum kind { REMOVES, WAKES, WAKES_BOTH, KINDS } kind;

static const char *const names[] = {"removed and added", "woken", "woken, and what is below"};

typedef struct subject {
    duet_motion *motion;
    uint64_t *ids; // of what is altered
    series cpu, commands, contacts;
} subject;

static double cpu_ms(void)
{
    return (double)clock() * 1e3 / CLOCKS_PER_SEC;
}

static duet_motion_def columns_def(duet_device_pair *pair)
{
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.gravity[2] = -9.81;
    def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP;
    def.skin = 0.05;
    def.boundary = DUET_BOUNDARY_WALLS;
    for (int k = 0; k < 3; ++k) {
        def.lower[k] = k == 2 ? 0 : -2;
        def.upper[k] = 4000;
    }
    return def;
}

// Body HIGH c + i is the i-th from below in column c.
static void fill_columns(duet_pose *poses, duet_body *bodies, uint32_t n)
{
    enum { WIDE = 160 };
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t column = i / HIGH;
        poses[i] = (duet_pose){{(float)(column % WIDE) * 1.5f, (float)(column / WIDE) * 1.5f,
                                0.5f + (float)(i % HIGH)},
                               {0.5f, 0.5f, 0.5f},
                               {0, 0, 0, 1}};
        bodies[i] = duet_default_body();
        bodies[i].friction = 0.5f;
    }
}

// The topmost of every 25th column.
static uint32_t altered_place(uint32_t i)
{
    return HIGH * EACH * i + HIGH - 1;
}

static bool alter(subject *s, kind k, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                  duet_error *err)
{
    const duet_body_list list = {.ids = s->ids, .n = k == WAKES_BOTH ? 2 * n : n};
    return k == REMOVES ? duet_motion_remove_bodies(s->motion, list, err) &&
                              duet_motion_add_bodies(s->motion, poses, bodies, n, s->ids, err)
                        : duet_motion_wake_bodies(s->motion, list, err);
}

static bool step(subject *s, kind k, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                 duet_motion_result *result, duet_error *err)
{
    double begun = cpu_ms();
    if (!alter(s, k, poses, bodies, n, err))
        return false;
    double told = cpu_ms();
    if (!duet_motion_advance(s->motion, result, err))
        return false;
    series_add(&s->commands, told - begun);
    series_add(&s->cpu, cpu_ms() - begun);
    series_add(&s->contacts, (double)result->contacts);
    return true;
}

static bool open_subject(subject *s, duet_device_pair *pair, const duet_pose *poses,
                         const duet_body *bodies, uint32_t n, duet_error *err)
{
    duet_motion_def def = columns_def(pair);
    duet_motion_result result;
    uint32_t n_altered = n / (HIGH * EACH);
    s->ids = malloc(2 * n_altered * sizeof *s->ids + 1);
    s->motion = s->ids ? duet_motion_create(&def, poses, bodies, n, err) : NULL;
    bool ok = s->motion;
    for (uint32_t i = 0; ok && i < n_altered; ++i) {
        s->ids[i] = altered_place(i);
        s->ids[n_altered + i] = altered_place(i) - 1;
    }
    for (int i = 0; ok && i < SETTLING; ++i)
        ok = duet_motion_advance(s->motion, &result, err);
    return ok;
}

static bool measure(subject *all, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                    uint32_t runs, duet_error *err)
{
    enum { WARM = 4 };
    duet_motion_result result;
    for (uint32_t run = 0; run < runs + WARM; ++run)
        for (int k = 0; k < KINDS; ++k) {
            subject *s = &all[k];
            if (run == WARM)
                s->cpu.n = s->commands.n = s->contacts.n = 0;
            if (!step(s, (kind)k, poses, bodies, n, &result, err))
                return false;
            if (getenv("BARS_STAGES") && run == runs + WARM - 1) {
                for (uint32_t i = 0; i < result.n_stages; ++i)
                    printf("%s %.2f | ", result.stages[i].name, result.stages[i].ms);
                printf("total %.2f\n", result.total_ms);
            }
        }
    return true;
}

static void print(const subject *all, uint32_t n)
{
    printf("%-25s %8s %9s %10s\n", "", "CPU ms", "commands", "contacts");
    for (int k = 0; k < KINDS; ++k)
        printf("%u %-20s %8.1f %9.1f %10.0f  %.2f\n", n, names[k], series_median(&all[k].cpu),
               series_median(&all[k].commands), series_median(&all[k].contacts),
               series_median(&all[k].cpu) / series_median(&all[WAKES].cpu));
}

bool bench_commands(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 100000, n_altered = n / (HIGH * EACH);
    duet_pose *poses = malloc(n * sizeof *poses), *tops = malloc((n_altered + 1) * sizeof *tops);
    duet_body *bodies = malloc(n * sizeof *bodies);
    subject *all = calloc(KINDS, sizeof *all);
    duet_device_pair *pair = poses && tops && bodies && all ? bench_pair(options, err) : NULL;
    bool ok = pair || error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bodies", n);
    if (ok)
        fill_columns(poses, bodies, n);
    for (uint32_t i = 0; ok && i < n_altered; ++i)
        tops[i] = poses[altered_place(i)];
    for (int k = 0; ok && k < KINDS; ++k)
        ok = open_subject(&all[k], pair, poses, bodies, n, err);
    ok = ok && measure(all, tops, bodies, n_altered, options->runs, err);
    if (ok)
        print(all, n_altered);
    for (int k = 0; all && k < KINDS; ++k) {
        duet_motion_destroy(all[k].motion);
        free(all[k].ids);
    }
    duet_device_pair_destroy(pair);
    free(all);
    free(bodies);
    free(tops);
    free(poses);
    return ok;
}
