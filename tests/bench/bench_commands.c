// SPDX-License-Identifier: MIT
// What commands cost: columns of cubes sleep, and before each step a hundredth of all, other ones
// each time, are removed and others put where they lay; beside it the same bodies are only woken,
// and with them those that they lay on, which lose their load where bodies are removed. Each
// fourth step has no commands: as many bodies are awake in it as in those before.
#include "bench.h"

enum { HIGH = 4, EACH = 25, SETTLING = 60 };

typedef enum kind { REMOVES, WAKES, WAKES_BOTH, KINDS } kind;

static const char *const names[] = {"removed and added", "woken", "woken, and what is below"};

typedef struct subject {
    duet_motion *motion;
    uint64_t *tops; // the id of each column's topmost body
    uint64_t *ids;  // ids of what is altered, and then of what is below
    series cpu, without, commands, contacts;
} subject;

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

// Every 25th column, others in each run.
static uint32_t altered_column(uint32_t i, uint32_t run)
{
    return EACH * i + run % EACH;
}

static void renew(subject *s, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                  uint32_t run)
{
    const duet_body_list list = {.ids = s->ids, .n = n};
    must(duet_motion_remove_bodies(s->motion, list, ERR));
    must(duet_motion_add_bodies(s->motion, poses, bodies, n, s->ids, ERR));
    for (uint32_t i = 0; i < n; ++i)
        s->tops[altered_column(i, run)] = s->ids[i];
}

static void alter(subject *s, kind k, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                  uint32_t run)
{
    const duet_body_list list = {.ids = s->ids, .n = k == WAKES_BOTH ? 2 * n : n};
    if (k == REMOVES)
        renew(s, poses, bodies, n, run);
    else
        must(duet_motion_wake_bodies(s->motion, list, ERR));
}

static void choose(subject *s, uint32_t n, uint32_t run)
{
    for (uint32_t i = 0; i < n; ++i) {
        s->ids[i] = s->tops[altered_column(i, run)];
        s->ids[n + i] = HIGH * altered_column(i, run) + HIGH - 2;
    }
}

static void step(subject *s, kind k, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                 uint32_t run)
{
    duet_motion_result result;
    bool with = run % 4 < 3;
    choose(s, n, run);
    double begun = bench_cpu_ms();
    if (with)
        alter(s, k, poses, bodies, n, run);
    double told = bench_cpu_ms();
    must(duet_motion_advance(s->motion, &result, ERR));
    series_add(with ? &s->cpu : &s->without, bench_cpu_ms() - begun);
    if (with)
        series_add(&s->commands, told - begun);
    series_add(&s->contacts, (double)result.contacts);
}

static subject open_subject(duet_device_pair *pair, const duet_pose *poses, const duet_body *bodies,
                            uint32_t n)
{
    duet_motion_def def = columns_def(pair);
    duet_motion_result result;
    subject s = {.motion = must(duet_motion_create(&def, poses, bodies, n, ERR)),
                 .ids = bench_alloc(2 * (n / (HIGH * EACH)) * sizeof *s.ids),
                 .tops = bench_alloc(n / HIGH * sizeof *s.tops)};
    for (uint32_t c = 0; c < n / HIGH; ++c)
        s.tops[c] = HIGH * c + HIGH - 1;
    for (int i = 0; i < SETTLING; ++i)
        must(duet_motion_advance(s.motion, &result, ERR));
    return s;
}

static void measure(subject *all, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                    uint32_t runs)
{
    enum { WARM = 40 }; // altered bodies sleep again after 30 steps
    duet_pose *tops = bench_alloc(n * sizeof *tops);
    for (uint32_t run = 0; run < runs + WARM; ++run) {
        for (uint32_t i = 0; i < n; ++i)
            tops[i] = poses[HIGH * altered_column(i, run) + HIGH - 1];
        for (int k = 0; k < KINDS; ++k) {
            if (run == WARM)
                all[k].cpu.n = all[k].without.n = all[k].commands.n = all[k].contacts.n = 0;
            step(&all[k], (kind)k, tops, bodies, n, run);
        }
    }
}

static void print(const subject *all, uint32_t n)
{
    printf("%-30s %9s %9s %9s %9s %6s\n", "CPU ms a step", "contacts", "commands", "with",
           "without", "ratio");
    for (int k = 0; k < KINDS; ++k) {
        const subject *s = &all[k];
        double with = series_median(&s->cpu), without = series_median(&s->without);
        printf("%5u %-24s %9.0f %9.1f %9.1f %9.1f %6.2f\n", n, names[k],
               series_median(&s->contacts), series_median(&s->commands), with, without,
               with / without);
    }
}

void bench_commands(const bench_options *options)
{
    uint32_t n = options->n ? options->n : 100000, n_altered = n / (HIGH * EACH);
    duet_pose *poses = bench_alloc(n * sizeof *poses);
    duet_body *bodies = bench_alloc(n * sizeof *bodies);
    duet_device_pair *pair = bench_pair(options);
    static subject all[KINDS];
    fill_columns(poses, bodies, n);
    for (int k = 0; k < KINDS; ++k)
        all[k] = open_subject(pair, poses, bodies, n);
    measure(all, poses, bodies, n_altered, options->runs);
    print(all, n_altered);
}
