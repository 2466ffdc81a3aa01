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

void background_start(background *b, void (*step)(void *), void *owner)
{
    b->err = (duet_error){0};
    b->under_way = true;
    thread_pool_start(b->thread, step, owner);
}

bool background_end(background *b, duet_error *err)
{
    thread_pool_wait(b->thread);
    b->under_way = false;
    return b->ok || error_copy(err, &b->err);
}
