// SPDX-License-Identifier: MIT
// A step in two halves: a thread of the motion's own carries it while the caller works. What a
// caller may ask meanwhile changes only in the second half.
#include "runtime/dynamics/motion_halves.h"

#include "base/error.h"
#include "runtime/opencl/thread_pool.h"

#include <stdlib.h>

struct motion_half {
    thread_pool *thread;
    bool under_way;
    duet_error err;
    bool ok;
    double ms;
};

bool motion_is_under_way(const duet_motion *m)
{
    return m->half && m->half->under_way;
}

bool motion_is_idle(const duet_motion *m, const char *call, duet_error *err)
{
    return !motion_is_under_way(m) ||
           error_set(
               err, DUET_STATUS_BAD_ARGUMENT,
               "%s: a step of the motion is under way; expected duet_motion_advance_end first",
               call);
}

static void carry(void *arg)
{
    duet_motion *m = arg;
    m->half->ok = motion_carry_step(m, &m->half->ms, &m->half->err);
}

static bool reserve(duet_motion *m, duet_error *err)
{
    if (m->half)
        return true;
    struct motion_half *h = calloc(1, sizeof *h);
    if (!h)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a step in two halves");
    h->thread = thread_pool_open(1, err);
    if (!h->thread) {
        free(h);
        return false;
    }
    m->half = h;
    return true;
}

bool duet_motion_advance_begin(duet_motion *m, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !reserve(m, err))
        return false;
    m->half->err = (duet_error){0};
    m->half->under_way = true;
    thread_pool_start(m->half->thread, carry, m);
    return true;
}

bool duet_motion_advance_end(duet_motion *m, duet_motion_result *result, duet_error *err)
{
    if (!error_given(m, __func__, "motion", err) || !error_given(result, __func__, "result", err))
        return false;
    struct motion_half *h = m->half;
    if (!motion_is_under_way(m))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: no step is under way; expected duet_motion_advance_begin first",
                         __func__);
    thread_pool_wait(h->thread);
    h->under_way = false;
    if (!h->ok && err && err->status == DUET_STATUS_OK)
        *err = h->err;
    return motion_complete_step(m, h->ok, h->ms, result, err);
}

void motion_end_half(duet_motion *m)
{
    if (!m->half)
        return;
    thread_pool_close(m->half->thread);
    free(m->half);
    m->half = NULL;
}
