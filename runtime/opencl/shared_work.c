// SPDX-License-Identifier: MIT
#include "runtime/opencl/shared_work.h"

#include "base/clock.h"
#include "base/error.h"

bool shared_work_check(uint32_t share, duet_error *err)
{
    return share <= DUET_SHARE_ONE ||
           bad_argument(err, "share is %u of %u; expected at most all of it", share,
                        DUET_SHARE_ONE);
}

static bool open_side(work_side *s, const duet_device_pair *pair, const char *kernel_dir, int which,
                      duet_error *err)
{
    s->device = &pair->devices[which];
    s->gen = gen_open(kernel_dir, err);
    s->programs = s->gen ? program_set_open(s->device, s->gen, &pair->builder, err) : NULL;
    return s->programs;
}

bool shared_work_open(shared_work *w, duet_device_pair *pair, const char *kernel_dir,
                      uint32_t share, work_side *a, work_side *b, duet_error *err)
{
    *w = (shared_work){.pair = pair, .share = share, .sides = {a, b}};
    device_pair_hold(pair);
    bool uses_a = share > 0, uses_b = share < DUET_SHARE_ONE;
    return (!uses_a || open_side(a, pair, kernel_dir, 0, err)) &&
           (!uses_b || open_side(b, pair, kernel_dir, 1, err)) &&
           (!uses_a || !uses_b || (w->driver = thread_pool_open(1, err)) != NULL);
}

void shared_work_close(shared_work *w)
{
    thread_pool_close(w->driver);
    for (int which = 0; which < 2; ++which) {
        work_side *s = w->sides[which];
        timeline_clear(&s->times);
        program_set_close(s->programs);
        gen_close(s->gen);
    }
    duet_device_pair_destroy(w->pair);
}

typedef struct job {
    work_side *side;
    bool (*part)(work_side *);
} job;

static void run_side(void *arg)
{
    const job *j = arg;
    work_side *s = j->side;
    uint64_t begun = clock_steady_ns();
    timeline_begin(&s->times, s->device, true);
    s->ok = j->part(s) && timeline_finish(&s->times, &s->err);
    timeline_clear(&s->times);
    s->wall_ms = clock_ms_since(begun);
}

// A's part of n, without a product that overflows.
static uint64_t part_of(uint64_t n, uint32_t share)
{
    return n / DUET_SHARE_ONE * share + n % DUET_SHARE_ONE * share / DUET_SHARE_ONE;
}

void shared_work_divide(shared_work *w, uint64_t n)
{
    uint64_t cut = part_of(n, w->share);
    w->sides[0]->first = 0;
    w->sides[0]->last = w->sides[1]->first = cut;
    w->sides[1]->last = n;
    for (int which = 0; w->part > 0 && which < 2; ++which) {
        work_side *s = w->sides[which];
        uint64_t items = s->last - s->first, done = part_of(items, w->part);
        s->last = s->first + (done > 0 ? done : items > 0);
    }
}

bool shared_work_run(shared_work *w, uint64_t n, bool (*part)(work_side *), duet_error *err)
{
    job jobs[2];
    shared_work_divide(w, n);
    uint64_t cut = w->sides[1]->first;
    for (int which = 0; which < 2; ++which) {
        work_side *s = w->sides[which];
        jobs[which] = (job){s, part};
        s->wall_ms = 0;
        s->ok = true;
        s->err = (duet_error){0};
    }
    thread_pool_run_both(w->driver, run_side, cut > 0 ? &jobs[0] : NULL, cut < n ? &jobs[1] : NULL);
    const work_side *failed = w->sides[w->sides[0]->ok];
    return failed->ok || error_copy(err, &failed->err);
}
