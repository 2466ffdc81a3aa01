// SPDX-License-Identifier: MIT
// Two devices against the better one of them, each way to split the work: the
// search alone (the paper shares no more than that) and the whole step. Beside
// them, two worlds of half the objects, each stepped by its own thread on its own
// device, show what there is to be had where nothing is shared but memory.
#include "bench.h"

#include "subject.h"
#include "workers.h"

enum { ALONE_A, ALONE_B, OWN, SHARED, SLAB, N };

static const struct {
    const char *name;
    duet_mode mode;
    uint32_t share;
} splits[N] = {
    [ALONE_A] = {"A alone", DUET_MODE_OWN, DUET_SHARE_ONE},
    [ALONE_B] = {"B alone", DUET_MODE_OWN, 0},
    [OWN] = {"own, share 0.5", DUET_MODE_OWN, DUET_SHARE_ONE / 2},
    [SHARED] = {"shared, share 0.5", DUET_MODE_SHARED, DUET_SHARE_ONE / 2},
    [SLAB] = {"slab, share 0.5", DUET_MODE_SLAB, DUET_SHARE_ONE / 2},
};

// The time of the better one of the devices alone.
static double alone(subject *const subjects[N], double (*value)(const subject *))
{
    return fmin(value(subjects[ALONE_A]), value(subjects[ALONE_B]));
}

static double search_median(const subject *s)
{
    return series_median(&s->searching);
}

static double step_median(const subject *s)
{
    return series_median(&s->total);
}

static double step_least(const subject *s)
{
    return series_least(&s->total);
}

// ---------------------------------------------------------------- two halves

typedef struct halves {
    subject *each[2];
    workers *workers;
    series total; // the longer one's
} halves;

static void halves_open(halves *h, const subject_def *whole)
{
    h->workers = workers_open(2);
    must(h->workers || error_set(ERR, DUET_STATUS_NO_MEMORY, "no second thread"));
    for (int i = 0; i < 2; ++i) {
        subject_def def = *whole;
        def.n = whole->n / 2;
        def.share = i == 0 ? DUET_SHARE_ONE : 0;
        h->each[i] = subject_open(def);
    }
}

static void step_half(void *context, uint32_t worker)
{
    subject_step(((halves *)context)->each[worker]);
}

static void halves_step(halves *h)
{
    workers_run(h->workers, step_half, h);
    series_add(&h->total, fmax(h->each[0]->last.total_ms, h->each[1]->last.total_ms));
}

// ---------------------------------------------------------------- all

static void print(subject *const subjects[N], const halves *h)
{
    static const struct {
        const char *name;
        double (*value)(const subject *);
    } columns[] = {{"search", search_median}, {"step", step_median}, {"least step", step_least}};
    enum { N_COLUMNS = sizeof columns / sizeof columns[0] };
    printf("%u objects\n%-20s", subjects[0]->def.n, "ms");
    for (int c = 0; c < N_COLUMNS; ++c)
        printf(" %10s %8s", columns[c].name, "to alone");
    printf(" %10s\n", "CPU time");
    for (int i = 0; i < N; ++i) {
        printf("%-20s", splits[i].name);
        for (int c = 0; c < N_COLUMNS; ++c) {
            double ms = columns[c].value(subjects[i]);
            printf(" %10.2f %8.2f", ms, ms / alone(subjects, columns[c].value));
        }
        printf(" %10.2f\n", series_median(&subjects[i]->cpu));
    }
    double median = series_median(&h->total), least = series_least(&h->total);
    printf("%-20s %19s %10.2f %8.2f %10.2f %8.2f\n", "two worlds of half", "", median,
           median / alone(subjects, step_median), least, least / alone(subjects, step_least));
    printf("wanted: search at most 0.62 of the better device alone; slab's step 0.58\n");
}

void bench_share(const bench_options *options)
{
    uint32_t n = options->n ? options->n : 500000;
    const duet_pose *poses = bench_poses(n, options);
    subject *subjects[N];
    static halves h;
    for (int i = 0; i < N; ++i)
        subjects[i] = subject_open((subject_def){.name = splits[i].name,
                                                 .device_a = options->device_a,
                                                 .device_b = options->device_b,
                                                 .variant = "simd",
                                                 .mode = splits[i].mode,
                                                 .share = splits[i].share,
                                                 .poses = poses,
                                                 .n = n});
    halves_open(&h, &subjects[OWN]->def);
    for (uint32_t run = 0; run < options->runs; ++run) {
        subjects_step(subjects, N, 1);
        halves_step(&h);
    }
    print(subjects, &h);
}
