// SPDX-License-Identifier: MIT
// A hundred million pairs about to touch: what float decides is what double and
// integers decide. A thread a core; on a terminal it shows its progress.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "support/hard_pairs.h"
#include "support/real.h"

#include "base/clock.h"
#include "support/narrow_float.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#define PAIRS 100000000
enum { MOST_THREADS = 64, EXACT_EVERY = 64 };

// ------------------------------------------------------------ pairs

typedef struct axes {
    double at[3][3];
} axes;

static axes axes_of(const duet_pose *pose)
{
    real axis[3][3];
    axes a;
    real_axes(axis, pose->rotation);
    for (int i = 0; i < 9; ++i)
        a.at[i / 3][i % 3] = (double)axis[i / 3][i % 3];
    return a;
}

static double dot(const double u[3], const double v[3])
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static double reach(const duet_pose *pose, const axes *a, const double along[3])
{
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += pose->half_extents[i] * fabs(dot(a->at[i], along));
    return sum;
}

typedef struct ray {
    const hard_pair *pair;
    axes a, b;
    double direction[3];
    double touch; // how far along it the boxes part, by the axes seen so far
} ray;

static void see_axis(ray *r, const double along[3])
{
    double speed = fabs(dot(r->direction, along));
    double size = reach(&r->pair->a, &r->a, along) + reach(&r->pair->b, &r->b, along);
    if (speed > 1e-9)
        r->touch = fmin(r->touch, size / speed);
}

static double touching_distance(const hard_pair *p, const double direction[3])
{
    ray r = {.pair = p, .a = axes_of(&p->a), .b = axes_of(&p->b), .touch = INFINITY};
    memcpy(r.direction, direction, sizeof r.direction);
    for (int i = 0; i < 3; ++i) {
        see_axis(&r, r.a.at[i]);
        see_axis(&r, r.b.at[i]);
        for (int j = 0; j < 3; ++j) {
            const double *u = r.a.at[i], *v = r.b.at[j];
            see_axis(&r, (double[]){u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                    u[0] * v[1] - u[1] * v[0]});
        }
    }
    return r.touch;
}

// Cubes, plates and needles; any turn, or nearly parallel ones.
static hard_pair pick_boxes(rng *r)
{
    hard_pair p = {0};
    double tilt = rng_below(r, 2) ? 1 : pow(10, -rng_between(r, 1, 9));
    double thin = rng_below(r, 2) ? 1 : pow(10, -rng_between(r, 0, 5));
    for (int i = 0; i < 4; ++i) {
        p.a.rotation[i] = (float)rng_between(r, -1, 1);
        p.b.rotation[i] = (float)(p.a.rotation[i] + tilt * rng_between(r, -1, 1));
    }
    p.a.rotation[3] += 2; // no length of 0, and no parts below 2^-30 of it
    p.b.rotation[3] += 2;
    for (int i = 0; i < 3; ++i) {
        p.a.half_extents[i] = (float)(rng_between(r, 0.3, 1) * (rng_below(r, 2) ? thin : 1));
        p.b.half_extents[i] = (float)(rng_between(r, 0.3, 1) * (rng_below(r, 2) ? thin : 1));
    }
    return p;
}

// From touching they are off by 2^-25 to 2^-12 of their distance.
static hard_pair pick_contact(rng *r)
{
    hard_pair p = pick_boxes(r);
    double direction[3];
    for (int i = 0; i < 3; ++i)
        direction[i] = rng_between(r, -1, 1);
    double off = (rng_below(r, 2) ? 1 : -1) * pow(2, -rng_between(r, 12, 25));
    double way = touching_distance(&p, direction) * (1 + off);
    double far = rng_below(r, 2) ? 0 : rng_between(r, -100, 100);
    for (int i = 0; i < 3; ++i) {
        p.a.centre[i] = (float)far;
        p.b.centre[i] = (float)(p.a.centre[i] + way * direction[i]);
    }
    return p;
}

// ------------------------------------------------------------ threads

typedef struct worker {
    pthread_t thread;
    uint64_t seed;
    uint64_t n;
    uint64_t open_in_float, open_in_double, collide;
    bool wrong;
    hard_pair at;
} worker;

static atomic_uint_fast64_t done;

static bool check(worker *w, const hard_pair *p, bool exactly)
{
    narrow_answer in_float = narrow_float(&p->a, &p->b, 3, true);
    narrow_answer in_double = narrow_double(&p->a, &p->b, 3);
    bool open = in_double == NARROW_UNDECIDED;
    bool truth = open || exactly ? narrow_exact(&p->a, &p->b, 3) : in_double == NARROW_COLLIDING;
    w->open_in_float += in_float == NARROW_UNDECIDED;
    w->open_in_double += open;
    w->collide += truth;
    return (in_float == NARROW_UNDECIDED || (in_float == NARROW_COLLIDING) == truth) &&
           (open || (in_double == NARROW_COLLIDING) == truth);
}

static void *run(void *arg)
{
    worker *w = arg;
    rng r = rng_seed(w->seed);
    for (uint64_t i = 0; i < w->n && !w->wrong; ++i) {
        hard_pair p = pick_contact(&r);
        if (!check(w, &p, i % EXACT_EVERY == 0)) {
            w->wrong = true;
            w->at = p;
        }
        if (i % 4096 == 4095)
            atomic_fetch_add(&done, 4096);
    }
    return NULL;
}

static void show_progress(uint64_t begun)
{
    if (!isatty(STDERR_FILENO))
        return;
    while (atomic_load(&done) + MOST_THREADS * 4096 < PAIRS) {
        double seconds = (double)(clock_steady_ns() - begun) * 1e-9;
        double rate = (double)atomic_load(&done) / (seconds + 1e-9);
        fprintf(stderr, "\r%5.1f %%, %.2f million a second, %.0f s left ",
                100.0 * (double)atomic_load(&done) / PAIRS, rate * 1e-6,
                ((double)PAIRS - (double)atomic_load(&done)) / (rate + 1));
        nanosleep(&(struct timespec){.tv_nsec = 500000000}, NULL);
    }
    fprintf(stderr, "\r%60s\r", "");
}

TEST(a_hundred_million_contacts_are_decided_rightly)
{
    static worker workers[MOST_THREADS];
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    int n = cores < 1 ? 1 : cores > MOST_THREADS ? MOST_THREADS : (int)cores;
    uint64_t seed = test_seed(), begun = clock_steady_ns();
    for (int i = 0; i < n; ++i) {
        workers[i] = (worker){.seed = seed + (uint64_t)i,
                              .n = PAIRS / (uint64_t)n + ((uint64_t)i < PAIRS % (uint64_t)n)};
        assert_int_equal(pthread_create(&workers[i].thread, NULL, run, &workers[i]), 0);
    }
    show_progress(begun);
    worker sum = {0};
    for (int i = 0; i < n; ++i) {
        pthread_join(workers[i].thread, NULL);
        sum.open_in_float += workers[i].open_in_float;
        sum.open_in_double += workers[i].open_in_double;
        sum.collide += workers[i].collide;
        if (workers[i].wrong)
            hard_pair_print(&workers[i].at, 3);
        sum.wrong |= workers[i].wrong;
    }
    print_message("%d pairs, %" PRIu64 " collide; float left %" PRIu64 " open, double %" PRIu64
                  ", in %.0f s\n",
                  PAIRS, sum.collide, sum.open_in_float, sum.open_in_double,
                  (double)(clock_steady_ns() - begun) * 1e-9);
    assert_false(sum.wrong);
}
