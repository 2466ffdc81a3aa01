// SPDX-License-Identifier: MIT
#include "tuner/measure_motion.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- owner

// From the scene's start again.
static bool begin(measure_motion *q, const duet_plan *plan, bool staged, duet_error *err)
{
    duet_motion_def def = q->def;
    def.plan = *plan;
    def.stage_times = staged;
    duet_motion_destroy(q->motion);
    q->motion = duet_motion_create_from_scene(&def, q->scene, NULL, err);
    return q->motion;
}

bool measure_motion_open(measure_motion *q, duet_device_pair *pair, const duet_scene *scene,
                         uint32_t steps, duet_error *err)
{
    *q =
        (measure_motion){.def = duet_scene_motion_def(scene, pair), .scene = scene, .steps = steps};
    if (steps < 2)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a run of %u step has none that counts, since the first builds kernels; "
                         "expected 2 or more",
                         steps);
    duet_plan plan = duet_default_plan(pair);
    return begin(q, &plan, false, err);
}

void measure_motion_close(measure_motion *q)
{
    duet_motion_destroy(q->motion);
    *q = (measure_motion){0};
}

bool measure_motion_is_shared(const measure_motion *q)
{
    return (q->motion->effects & DUET_EFFECT_CONTACT) && !duet_device_pair_is_one(q->def.pair);
}

// ---------------------------------------------------------------- a run

// Sums the times of a run's steps.
typedef struct sums {
    double total_ms;
    double search_ms[2]; // by device
    duet_stage stages[MEASURE_STAGES];
    uint32_t n_stages;
    core_use use;
} sums;

static void add_stages(sums *s, const duet_stage *stages, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t k = 0;
        while (k < s->n_stages && (s->stages[k].device != stages[i].device ||
                                   strcmp(s->stages[k].name, stages[i].name) != 0))
            ++k;
        if (k == MEASURE_STAGES)
            continue;
        if (k == s->n_stages) {
            s->stages[s->n_stages] = stages[i];
            s->stages[s->n_stages++].ms = 0;
        }
        s->stages[k].ms += stages[i].ms;
    }
}

static void add_step(sums *s, const duet_motion *m, const duet_motion_result *step)
{
    const duet_result *search = &m->graph.searched;
    s->total_ms += step->total_ms;
    for (uint32_t i = 0; step->timed && i < step->n_stages; ++i) {
        duet_stage stage = step->stages[i];
        stage.device = 1;
        add_stages(s, &stage, 1);
    }
    if (!step->rebuilt)
        return;
    for (int side = 0; side < 2; ++side)
        s->search_ms[side] += search->device_ms[side];
    if (search->timed)
        add_stages(s, search->stages, search->n_stages);
}

static bool run(measure_motion *q, const duet_plan *plan, bool staged, sums *s, duet_error *err)
{
    duet_motion_result step;
    bool ok = begin(q, plan, staged, err) && duet_motion_advance(q->motion, &step, err);
    core_watch_start(q->cores);
    for (uint32_t i = 1; ok && i < q->steps; ++i) {
        ok = duet_motion_advance(q->motion, &step, err);
        if (ok)
            add_step(s, q->motion, &step);
    }
    s->use = core_watch_stop(q->cores);
    return ok;
}

static int64_t mean_ns(const measure_motion *q, double ms)
{
    return (int64_t)(ms * 1e6 / (q->steps - 1) + 0.5);
}

static bool launch_motion(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                          duet_error *err)
{
    measure_motion *q = context;
    sums s = {0};
    *launch = (measure_launch){0};
    if (!run(q, plan, staged, &s, err) || !duet_motion_get_hash(q->motion, &launch->hash, err))
        return false;
    bool a = plan->share > 0, b = plan->share < DUET_SHARE_ONE;
    launch->use = s.use;
    launch->total_ns = mean_ns(q, s.total_ms);
    launch->a_ns = a ? mean_ns(q, s.search_ms[0]) : 0;
    launch->b_ns = b ? mean_ns(q, s.search_ms[1]) : 0;
    launch->n_stages = s.n_stages;
    for (uint32_t i = 0; i < s.n_stages; ++i) {
        launch->stages[i] = s.stages[i];
        launch->stages[i].ms /= q->steps - 1;
    }
    return true;
}

measure_machine measure_motion_machine(measure_motion *q, uint64_t hash)
{
    return (measure_machine){.context = q, .launch = launch_motion, .hash = hash};
}

bool measure_motion_right(measure_motion *q, uint64_t *hash, duet_error *err)
{
    measure_launch launch;
    duet_plan plan = duet_default_plan(q->def.pair);
    plan.share = 0;
    bool ok = launch_motion(q, &plan, false, &launch, err);
    *hash = launch.hash;
    return ok;
}

// ---------------------------------------------------------------- kernels

static bool has_run(const measure_motion *q, const duet_plan *plan)
{
    const duet_plan *last = q->motion ? &q->motion->def.plan : NULL;
    return last && q->motion->step > 0 && last->share == plan->share && last->mode == plan->mode &&
           strcmp(last->variant_a, plan->variant_a) == 0 &&
           strcmp(last->variant_b, plan->variant_b) == 0;
}

// Appends the kernels of the search to the motion's own.
static bool join(kernel_space **spaces, uint32_t *n, duet_motion *m, int side, duet_error *err)
{
    kernel_space *more = NULL;
    uint32_t n_more = 0;
    bool ok = kernel_spaces_read(m->graph.world, side, &more, &n_more, err);
    kernel_space *all = ok ? realloc(*spaces, (*n + n_more + 1) * sizeof *all) : NULL;
    if (all) {
        memcpy(all + *n, more, n_more * sizeof *all);
        *spaces = all;
        *n += n_more;
    } else if (ok) {
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "no memory for kernels' configs");
    }
    free(more);
    return ok;
}

bool measure_motion_kernels(measure_motion *q, const duet_plan *plan, int side,
                            kernel_space **spaces, uint32_t *n, duet_error *err)
{
    sums s = {0};
    *spaces = NULL;
    *n = 0;
    if (!has_run(q, plan) && !run(q, plan, false, &s, err))
        return false;
    duet_motion *m = q->motion;
    bool searches = m->graph.world && world_is_prepared(m->graph.world, side);
    return (side == 0 || motion_kernel_spaces(m, spaces, n, err)) &&
           (!searches || join(spaces, n, m, side, err));
}
