// SPDX-License-Identifier: MIT
// The narrow phase alone: answers of pairs that the caller brings.
//
// A takes the first share of the pairs and B the rest, at the same time. Each
// device takes its pairs a chunk at a time, so that any number fits, and what
// float leaves open of a chunk is decided before the next one.
#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/thread_pool.h"
#include "runtime/opencl/timeline.h"

#include <math.h>
#include <stdlib.h>

enum { COOKIE = 0x0d0e7007 };

// Some 20 MB of poses: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 18 };

// What a device says of a pair besides 0 and 1, as in kernels/narrowphase/pair_query.cl.
enum { UNDECIDED = 2, NO_BOX = 3 };

// What the caller brought, and which of its pairs are meant.
typedef struct work {
    const duet_pose *poses;
    uint8_t *answers;
    double *separations;
    uint64_t first, last;
} work;

// One device, and what it does of a call.
typedef struct side {
    const device *device;
    gen *gen;
    program_set *programs;
    kernel *kernel;
    timeline times;
    buffer poses;
    buffer found;
    cl_uint n; // of the pairs that were launched last
    uint32_t dims;

    work work;
    uint64_t colliding, undecided;
    double wall_ms;
    bool ok;
    duet_error err;
} side;

static const binding side_bindings[] = {BIND_BUFFER(side, "poses", "float *", poses),
                                        BIND_BUFFER(side, "answers", "uchar *", found),
                                        BIND_VALUE(side, "n", n),
                                        {0}};

struct duet_pair_query {
    duet_pair_query_def def;
    side sides[2];       // A, B
    thread_pool *driver; // drives A while the caller's thread drives B
};

duet_pair_query_def duet_default_pair_query_def(void)
{
    return (duet_pair_query_def){.dims = 3, .cookie = COOKIE};
}

// ---------------------------------------------------------------- owner

static bool check_def(const duet_pair_query_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the test's def does not come from duet_default_pair_query_def");
    if (!def->pair)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "the test's def has no device pair");
    if (def->dims != 2 && def->dims != 3)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "dims is %u; expected 2 or 3", def->dims);
    if (!duet_level_get_info(def->level))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "level is %d; expected a duet_level",
                         (int)def->level);
    if (def->share > DUET_SHARE_ONE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "share is %u of %u; expected at most all of it", def->share,
                         DUET_SHARE_ONE);
    return true;
}

static void close_side(side *s)
{
    timeline_clear(&s->times);
    buffer_release(&s->poses);
    buffer_release(&s->found);
    program_set_close(s->programs);
    gen_close(s->gen);
    *s = (side){0};
}

static bool open_side(side *s, const duet_pair_query_def *def, int which, duet_error *err)
{
    *s = (side){.device = &def->pair->devices[which], .dims = def->dims};
    const gen_setting settings[] = {{"DIMS", def->dims}, {"ACCURACY", def->level}};
    s->gen = gen_open(def->pair->kernel_dir, err);
    s->programs = s->gen ? program_set_open(s->device, s->gen, &def->pair->builder, err) : NULL;
    if (s->programs)
        s->kernel = program_set_kernel(s->programs, "pair_query", "pair_query", settings, 2,
                                       side_bindings, err);
    return s->kernel && program_set_build(s->programs, err) &&
           buffer_reserve(&s->found, s->device, CHUNK, err);
}

duet_pair_query *duet_pair_query_create(const duet_pair_query_def *def, duet_error *err)
{
    if (!check_def(def, err))
        return NULL;
    duet_pair_query *test = calloc(1, sizeof *test);
    if (!test) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a test");
        return NULL;
    }
    test->def = *def;
    device_pair_hold(def->pair);
    const bool used[2] = {def->share > 0, def->share < DUET_SHARE_ONE};
    bool ok = true;
    for (int which = 0; which < 2; ++which)
        ok = ok && (!used[which] || open_side(&test->sides[which], def, which, err));
    if (ok && used[0] && used[1])
        ok = (test->driver = thread_pool_open(1, err)) != NULL;
    if (!ok) {
        duet_pair_query_destroy(test);
        return NULL;
    }
    return test;
}

void duet_pair_query_destroy(duet_pair_query *test)
{
    if (!test)
        return;
    thread_pool_close(test->driver);
    close_side(&test->sides[0]);
    close_side(&test->sides[1]);
    duet_device_pair_destroy(test->def.pair);
    free(test);
}

// ---------------------------------------------------------------- a chunk

static bool send_poses(side *s, const duet_pose *poses, size_t bytes)
{
    return buffer_hold(&s->poses, s->device, (void *)poses, bytes, &s->err) &&
           timeline_write(&s->times, "send poses", &s->poses, poses, bytes, &s->err);
}

static bool ask_device(side *s, uint64_t first, uint32_t n)
{
    const work *w = &s->work;
    size_t bytes = 2 * (size_t)n * sizeof(duet_pose);
    s->n = n;
    return send_poses(s, w->poses + 2 * first, bytes) &&
           timeline_launch(&s->times, "test", s->kernel, n, s, &s->err) &&
           timeline_read(&s->times, "fetch answers", &s->found, w->answers + first, n, &s->err);
}

static bool refuse(side *s, uint64_t pair)
{
    bool first_is_box = narrow_is_box(&s->work.poses[2 * pair], s->dims);
    return error_set(&s->err, DUET_STATUS_BAD_OBJECT,
                     "pair %llu: the %s pose is not a number, infinite, negative or without "
                     "rotation",
                     (unsigned long long)pair, first_is_box ? "second" : "first");
}

// The device's word is the last one but where float is undecided.
static bool decide(side *s, uint64_t pair)
{
    const duet_pose *poses = s->work.poses + 2 * pair;
    uint8_t *answer = &s->work.answers[pair];
    if (*answer == NO_BOX)
        return refuse(s, pair);
    if (*answer == UNDECIDED) {
        *answer = narrow_decide(&poses[0], &poses[1], s->dims);
        ++s->undecided;
    }
    s->colliding += *answer;
    return true;
}

static bool test_chunk(side *s, uint64_t first, uint32_t n)
{
    if (!ask_device(s, first, n))
        return false;
    const work *w = &s->work;
    for (uint64_t pair = first; pair < first + n; ++pair)
        if (!decide(s, pair))
            return false;
    for (uint64_t pair = first; w->separations && pair < first + n; ++pair)
        w->separations[pair] =
            duet_poses_separation(&w->poses[2 * pair], &w->poses[2 * pair + 1], s->dims);
    return true;
}

// ---------------------------------------------------------------- all pairs

static bool has_work(const side *s)
{
    return s->work.first < s->work.last;
}

static void run_side(void *arg)
{
    side *s = arg;
    uint64_t begun = clock_steady_ns();
    timeline_begin(&s->times, s->device);
    for (uint64_t first = s->work.first; s->ok && first < s->work.last; first += CHUNK) {
        uint64_t left = s->work.last - first;
        s->ok =
            budget_check(&s->err) && test_chunk(s, first, left < CHUNK ? (uint32_t)left : CHUNK);
    }
    s->ok = s->ok && timeline_finish(&s->times, &s->err);
    timeline_clear(&s->times);
    if (s->poses.borrowed) // the caller may free it
        buffer_release(&s->poses);
    s->wall_ms = clock_ms_since(begun);
}

static void begin_side(side *s, const work *w, uint64_t first, uint64_t last)
{
    s->work = *w;
    s->work.first = first;
    s->work.last = last;
    s->colliding = s->undecided = 0;
    s->wall_ms = 0;
    s->ok = true;
    s->err = (duet_error){0};
}

// A's part of n, without a product that overflows.
static uint64_t part_of(uint64_t n, uint32_t share)
{
    return n / DUET_SHARE_ONE * share + n % DUET_SHARE_ONE * share / DUET_SHARE_ONE;
}

bool duet_pair_query_run(duet_pair_query *test, const duet_pose *poses, uint64_t n,
                         uint8_t *answers, double *separations, duet_pair_query_result *result,
                         duet_error *err)
{
    if (!error_given(test, __func__, "test", err) || !error_given(result, __func__, "result", err))
        return false;
    uint64_t begun = clock_steady_ns();
    if (n > 0 && (!poses || !answers))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%llu pairs, but no memory for their %s",
                         (unsigned long long)n, poses ? "answers" : "poses");
    side *a = &test->sides[0], *b = &test->sides[1];
    const work w = {.poses = poses, .answers = answers, .separations = separations};
    uint64_t cut = part_of(n, test->def.share);
    begin_side(a, &w, 0, cut);
    begin_side(b, &w, cut, n);
    thread_pool_run_both(test->driver, run_side, has_work(a) ? a : NULL, has_work(b) ? b : NULL);
    const side *failed = a->ok ? b : a; // A's pairs are the first ones
    if (!failed->ok) {
        if (err && err->status == DUET_STATUS_OK)
            *err = failed->err;
        return false;
    }
    *result = (duet_pair_query_result){.colliding = a->colliding + b->colliding,
                                       .undecided = a->undecided + b->undecided,
                                       .total_ms = clock_ms_since(begun),
                                       .device_ms = {a->wall_ms, b->wall_ms}};
    return true;
}
