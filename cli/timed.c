// SPDX-License-Identifier: MIT
#include "cli/timed.h"

#include "base/clock.h"
#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "runtime/broadphase/world.h"
#include "runtime/scene/scene.h"
#include "tuner/measure.h"

#include <stdlib.h>
#include <string.h>

enum { STAGED_MOST = 15 };

const char *timed_input_name(timed_input input)
{
    static const char *const names[] = {"host", "resident", "transforms", "compact"};
    return names[input];
}

bool timed_input_named(const char *name, timed_input *input)
{
    int i = 0;
    while (i < TIMED_INPUTS && strcmp(name, timed_input_name((timed_input)i)) != 0)
        ++i;
    *input = (timed_input)i;
    return i < TIMED_INPUTS;
}

static bool add(timed *t, uint32_t *n, const duet_result *result, duet_error *err)
{
    timed_step *step = &t->steps[t->n + t->n_staged];
    step->stages = calloc(result->n_stages + 1, sizeof *step->stages);
    if (!step->stages)
        return no_memory(err, "the times of a step");
    if (result->n_stages > 0)
        memcpy(step->stages, result->stages, result->n_stages * sizeof *step->stages);
    step->n_stages = result->n_stages;
    step->total_ms = result->total_ms;
    memcpy(step->kernel_ms, result->kernel_ms, sizeof step->kernel_ms);
    memcpy(step->device_ms, result->device_ms, sizeof step->device_ms);
    ++*n;
    return true;
}

static int by_time(const void *a, const void *b)
{
    double x = ((const timed_step *)a)->total_ms;
    double y = ((const timed_step *)b)->total_ms;
    return (x > y) - (x < y);
}

static void sort(timed *t)
{
    qsort(t->steps, t->n, sizeof *t->steps, by_time);
    qsort(t->steps + t->n, t->n_staged, sizeof *t->steps, by_time);
}

static bool hand_over(duet_world *world, const duet_scene *scene, timed_input input,
                      duet_error *err)
{
    if (input == TIMED_INPUT_RESIDENT)
        return true;
    if (input != TIMED_INPUT_HOST)
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
                     t->n + t->n_staged);
}

// Counts the step as one of *n.
static bool step(timed *t, uint32_t *n, duet_world *world, const duet_scene *scene,
                 timed_input input, core_watch *cores, duet_error *err)
{
    if (!hand_over(world, scene, input, err))
        return false;
    measure_watch(cores, world->def.pair);
    if (!duet_world_step(world, &t->last, err) || !add(t, n, &t->last, err))
        return false;
    core_watch_stop(cores);
    return check_hash(t, err);
}

// Being timed by stages makes a GPU's step longer, so that is done apart.
static bool step_staged(timed *t, duet_world *world, const duet_scene *scene, timed_input input,
                        duet_error *err)
{
    const uint32_t most = t->n < STAGED_MOST ? t->n : STAGED_MOST;
    const bool asked = world->def.stage_times;
    bool ok = true;
    world->def.stage_times = true;
    while (ok && t->n_staged < most && !interrupt_asked())
        ok = step(t, &t->n_staged, world, scene, input, NULL, err);
    world->def.stage_times = asked;
    return ok;
}

bool timed_run(timed *t, duet_world *world, const duet_scene *scene, uint32_t repeat,
               timed_input input, duet_error *err)
{
    t->steps = calloc((size_t)repeat + STAGED_MOST, sizeof *t->steps);
    if (!t->steps)
        return no_memory(err, "the times of %u steps", repeat);
    progress p = progress_begin("step", repeat);
    bool ok = duet_world_set_scene(world, scene, err) && duet_world_step(world, &t->last, err);
    t->hash = ok ? duet_result_get_hash(&t->last) : 0;
    bool untimed = false;
    core_watch *cores = core_watch_open();
    p.begun_ns = clock_steady_ns(); // the first step compiles, and does not count
    while (ok && t->n < repeat && !interrupt_asked()) {
        ok = step(t, &t->n, world, scene, input, cores, err);
        untimed |= ok && !t->last.timed;
        progress_show(&p, t->n);
    }
    progress_end(&p);
    t->cores = core_watch_tally(cores);
    core_watch_close(cores);
    ok = ok && (!untimed || step_staged(t, world, scene, input, err));
    if (ok && t->n == 0)
        ok = interrupt_check(err);
    sort(t);
    return ok;
}

// ---------------------------------------------------------------- tasks

static bool launch(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                   core_watch *cores, duet_error *err)
{
    task_result r;
    task_launch_reset(l, plan);
    measure_watch(cores, pair); // resetting and checking are not in the time
    if (!task_launch_unchecked(l, plan, &r, err))
        return false;
    core_watch_stop(cores);
    const duet_result times = {.total_ms = r.total_ms,
                               .device_ms = {r.device_ms[0], r.device_ms[1]},
                               .stages = r.stages,
                               .n_stages = r.n_stages};
    return task_launch_check(l, err) && add(t, &t->n, &times, err);
}

bool timed_task_run(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                    uint32_t repeat, duet_error *err)
{
    task_result first;
    t->steps = calloc(repeat, sizeof *t->steps);
    if (!t->steps)
        return no_memory(err, "the times of %u launches", repeat);
    core_watch *cores = core_watch_open();
    bool ok = task_launch(l, plan, &first, err);
    while (ok && t->n < repeat && !interrupt_asked())
        ok = launch(t, l, pair, plan, cores, err);
    t->cores = core_watch_tally(cores);
    core_watch_close(cores);
    sort(t);
    return ok && (t->n > 0 || interrupt_check(err));
}

// ---------------------------------------------------------------- both

void timed_free(timed *t)
{
    for (uint32_t i = 0; i < t->n + t->n_staged; ++i)
        free(t->steps[i].stages);
    free(t->steps);
}

const timed_step *timed_median(const timed *t)
{
    return &t->steps[(t->n - 1) / 2];
}

const timed_step *timed_staged(const timed *t)
{
    return t->n_staged > 0 ? &t->steps[t->n + (t->n_staged - 1) / 2] : timed_median(t);
}
