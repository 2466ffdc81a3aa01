// SPDX-License-Identifier: MIT
// A step in two halves: a thread of the world's own runs it while the caller works.
#include "runtime/broadphase/world.h"

#include "base/error.h"

// A command that waits for a failed event hangs under PoCL 3.1, or ends the process: a step that
// failed has rather left 0 pairs.
static void complete(step_half *h, bool ok)
{
    if (!h->done)
        return;
    clSetUserEventStatus(h->done, ok ? CL_COMPLETE : -1);
    clReleaseEvent(h->done);
    device_object_gone();
    h->done = NULL;
}

static bool run(void *arg, duet_error *err)
{
    duet_world *world = arg;
    bool ok = world_step(world, &world->half.result, err);
    complete(&world->half, world->left.last.count);
    return ok;
}

static bool start(duet_world *world, cl_event done, duet_error *err)
{
    if (!background_open(&world->background, err))
        return false;
    world->half = (step_half){.done = done};
    background_start(&world->background, run, world);
    return true;
}

bool duet_world_step_begin(duet_world *world, duet_error *err)
{
    PUBLIC_CALL(err);
    return world_is_idle(world, __func__, err) && start(world, NULL, err);
}

bool duet_world_step_begin_event(duet_world *world, cl_event *done, duet_error *err)
{
    PUBLIC_CALL(err);
    cl_int code = CL_SUCCESS;
    if (!world_is_idle(world, __func__, err) || !error_given(done, __func__, "done", err))
        return false;
    *done = NULL;
    if (!world->left.device)
        return bad_argument(
            err, "%s: pairs come to the host; expected duet_world_leave_pairs first", __func__);
    if (!background_open(&world->background, err))
        return false;
    cl_event event = clCreateUserEvent(world->left.device->context, &code);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s: making an event", __func__);
    device_object_made();
    clRetainEvent(event);
    *done = event;
    return start(world, event, err);
}

bool duet_world_step_end(duet_world *world, duet_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(world, __func__, "world", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    if (!world_is_under_way(world))
        return bad_argument(err, "%s: no step is under way; expected duet_world_step_begin first",
                            __func__);
    bool ok = background_end(&world->background, err);
    *result = world->half.result;
    return ok;
}
