// SPDX-License-Identifier: MIT
#include "runtime/opencl/background.h"

#include "base/error.h"

bool background_open(background *b, duet_error *err)
{
    if (!b->thread)
        b->thread = thread_pool_open(1, err);
    return b->thread;
}

void background_close(background *b)
{
    thread_pool_close(b->thread);
    *b = (background){0};
}

static void run(void *arg, uint64_t first, uint64_t last)
{
    background *b = arg;
    (void)first;
    (void)last;
    b->ok = b->step(b->owner, &b->err);
}

void background_start(background *b, bool (*step)(void *owner, duet_error *err), void *owner)
{
    b->err = (duet_error){0};
    b->step = step;
    b->owner = owner;
    thread_pool_start(b->thread, run, b, 1);
}

bool background_end(background *b, duet_error *err)
{
    thread_pool_wait(b->thread);
    b->owner = NULL;
    return b->ok || error_copy(err, &b->err);
}
