// SPDX-License-Identifier: MIT
// A motion of a scene as a subject: a launch is a run from the scene's start, and is right if the
// state after its last step has the right bits.
#include "tuner/subject.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"

// Its state is the last run's motion, NULL if it could not begin; at first one that has not moved.

// ---------------------------------------------------------------- owner

// From the scene's start again.
static bool begin(subject *s, const duet_plan *plan, bool staged, duet_error *err)
{
    duet_motion_def def = duet_scene_motion_def(s->def->scene, s->pair);
    def.plan = *plan;
    def.stage_times = staged;
    duet_motion_destroy(s->state);
    s->state = duet_motion_create_from_scene(&def, s->def->scene, NULL, err);
    return s->state;
}

// The first step of a run, which builds kernels and makes space, does not count.
static bool open(subject *s, duet_error *err)
{
    if (s->def->steps < 2)
        return bad_argument(err,
                            "a run of %u step has none that counts, since the first builds "
                            "kernels; expected 2 or more",
                            s->def->steps);
    if (!begin(s, &s->plan, false, err))
        return false;
    s->units = duet_scene_get_info(s->def->scene)->n;
    // Both devices have something to do if pairs are searched.
    s->one_device |= !(((duet_motion *)s->state)->effects & DUET_EFFECT_CONTACT);
    return true;
}

static void close(subject *s)
{
    duet_motion_destroy(s->state);
}

static bool describe(subject *s, profile_subject *p, duet_error *err)
{
    return profile_subject_read_motion(s->state, p, err);
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
        uint32_t k = measure_find_stage(s->stages, s->n_stages, &stages[i]);
        if (k < s->n_stages)
            s->stages[k].ms += stages[i].ms;
        else if (k < MEASURE_STAGES)
            s->stages[s->n_stages++] = stages[i];
    }
}

static void add_step(sums *s, const duet_motion *m, const duet_motion_result *step)
{
    const duet_result *found = &m->graph.searched;
    s->total_ms += step->total_ms;
    for (uint32_t i = 0; step->timed && i < step->n_stages; ++i) {
        duet_stage stage = step->stages[i];
        stage.device = 1;
        add_stages(s, &stage, 1);
    }
    if (!step->rebuilt)
        return;
    for (int side = 0; side < 2; ++side)
        s->search_ms[side] += found->device_ms[side];
    if (found->timed)
        add_stages(s, found->stages, found->n_stages);
}

static bool run(subject *s, const duet_plan *plan, bool staged, sums *sum, duet_error *err)
{
    duet_motion_result step;
    bool ok = begin(s, plan, staged, err) && duet_motion_advance(s->state, &step, err);
    measure_watch(s->cores, s->pair);
    for (uint32_t i = 1; ok && i < s->def->steps; ++i) {
        ok = duet_motion_advance(s->state, &step, err);
        if (ok)
            add_step(sum, s->state, &step);
    }
    sum->use = core_watch_stop(s->cores);
    return ok;
}

static int64_t mean_ns(const subject *s, double ms)
{
    return (int64_t)(ms * 1e6 / (s->def->steps - 1) + 0.5);
}

// A launch's times are those of a step in the mean of the run, as an application pays for it: most
// steps of a motion with a skin search no pairs, so that a median would leave the search out.
static bool launch_motion(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                          duet_error *err)
{
    subject *s = context;
    sums sum = {0};
    *launch = (measure_launch){0};
    if (!run(s, plan, staged, &sum, err) || !duet_motion_get_hash(s->state, &launch->hash, err))
        return false;
    bool a = plan->share > 0, b = plan->share < DUET_SHARE_ONE;
    launch->use = sum.use;
    launch->total_ns = mean_ns(s, sum.total_ms);
    launch->a_ns = a ? mean_ns(s, sum.search_ms[0]) : 0;
    launch->b_ns = b ? mean_ns(s, sum.search_ms[1]) : 0;
    launch->n_stages = sum.n_stages;
    for (uint32_t i = 0; i < sum.n_stages; ++i) {
        launch->stages[i] = sum.stages[i];
        launch->stages[i].ms /= s->def->steps - 1;
    }
    return true;
}

// The state's hash after a run by the default plan.
static bool find_truth(subject *s, subject_truth *truth, duet_error *err)
{
    measure_launch launch;
    duet_plan plan = duet_default_plan(s->pair);
    plan.share = 0;
    bool ok = launch_motion(s, &plan, false, &launch, err);
    truth->hash = launch.hash;
    return ok;
}

// ---------------------------------------------------------------- kernels

static bool has_run(const duet_motion *m, const duet_plan *plan)
{
    return m && m->step > 0 && trial_log_same_plan(&m->def.plan, plan);
}

// B's kernels of the motion, and both devices' kernels that search pairs. Runs the motion unless
// its last run was by that plan.
static bool read_kernels(void *context, const duet_plan *plan, int side, kernel_spaces *to,
                         duet_error *err)
{
    subject *s = context;
    sums sum = {0};
    if (!has_run(s->state, plan) && !run(s, plan, false, &sum, err))
        return false;
    duet_motion *m = s->state;
    bool searches = m->graph.world && world_is_prepared(m->graph.world, side);
    return (side == 0 || motion_kernel_spaces(m, to, err)) &&
           (!searches || kernel_spaces_read(m->graph.world, side, to, err));
}

const subject_kind subject_motion = {
    .has = "steps of a motion have",
    .asked_by = SUBJECT_STEPS,
    .takes = SUBJECT_SCENE | SUBJECT_STEPS | SUBJECT_SEARCH | SUBJECT_VARIANTS | SUBJECT_MODES,
    .searches = true,
    .open = open,
    .close = close,
    .describe = describe,
    .find_truth = find_truth,
    .machine = {.launch = launch_motion, .read_kernels = read_kernels},
    .lives_on_one = true,
};
