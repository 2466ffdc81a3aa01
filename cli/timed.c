// SPDX-License-Identifier: MIT
#include "cli/timed.h"

#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "runtime/broadphase/world.h"
#include "runtime/scene/scene.h"

#include <stdlib.h>
#include <string.h>

static bool keep_step(timed *t, const duet_result *result, duet_error *err)
{
    timed_step *step = &t->steps[t->n];
    step->stages = calloc(result->n_stages + 1, sizeof *step->stages);
    if (!step->stages)
        return error_set(err, DUET_STATUS_NO_MEMORY, "the times of a step: no memory");
    for (uint32_t i = 0; i < result->n_stages; ++i)
        step->stages[i] = result->stages[i];
    step->n_stages = result->n_stages;
    step->total_ms = result->total_ms;
    memcpy(step->kernel_ms, result->kernel_ms, sizeof step->kernel_ms);
    step->device_ms[0] = result->device_ms[0];
    step->device_ms[1] = result->device_ms[1];
    ++t->n;
    return true;
}

static int by_time(const void *a, const void *b)
{
    double x = ((const timed_step *)a)->total_ms;
    double y = ((const timed_step *)b)->total_ms;
    return (x > y) - (x < y);
}

static bool hand_over(duet_world *world, const duet_scene *scene, timed_sends sends,
                      duet_error *err)
{
    if (sends == TIMED_SENDS_NOTHING)
        return true;
    if (sends == TIMED_SENDS_TRANSFORMS)
        return world_take_transforms(world, duet_scene_get_objects(scene, DUET_OBJECT_POSES),
                                     duet_scene_get_info(scene)->n, err);
    duet_object_kind kind = scene_kind(duet_scene_get_info(scene));
    return duet_world_set_objects(world, kind, duet_scene_get_objects(scene, kind),
                                  duet_scene_get_info(scene)->n, err);
}

static bool check_hash(const timed *t, duet_error *err)
{
    return duet_result_get_hash(&t->last) == t->hash ||
           error_set(err, DUET_STATUS_WRONG_RESULT, "step %u found other pairs than the first",
                     t->n);
}

bool timed_run(timed *t, duet_world *world, const duet_scene *scene, uint32_t repeat,
               timed_sends sends, duet_error *err)
{
    t->steps = calloc(repeat, sizeof *t->steps);
    if (!t->steps)
        return error_set(err, DUET_STATUS_NO_MEMORY, "the times of %u steps: no memory", repeat);
    bool ok = duet_world_set_scene(world, scene, err) && duet_world_step(world, &t->last, err);
    t->hash = ok ? duet_result_get_hash(&t->last) : 0;
    progress p = progress_begin("step", repeat);
    while (ok && t->n < repeat && !interrupt_asked()) {
        ok = hand_over(world, scene, sends, err);
        ok = ok && duet_world_step(world, &t->last, err);
        ok = ok && keep_step(t, &t->last, err) && check_hash(t, err);
        progress_show(&p, t->n);
    }
    progress_end(&p);
    if (ok && t->n == 0)
        ok = interrupt_check(err);
    if (t->n > 0)
        qsort(t->steps, t->n, sizeof *t->steps, by_time);
    return ok;
}

void timed_free(timed *t)
{
    for (uint32_t i = 0; i < t->n; ++i)
        free(t->steps[i].stages);
    free(t->steps);
}

const timed_step *timed_median(const timed *t)
{
    return &t->steps[(t->n - 1) / 2];
}
