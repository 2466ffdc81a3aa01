// SPDX-License-Identifier: MIT
// A world, a motion or a task whose plan follows its frames' times. The kernels that a world may
// change to are built and timed where it is created, so that no frame waits for them. A motion's
// frames are its searches, and only their share moves: its kernels cannot be timed beside the run,
// since each step changes the state. A task, too, moves its share alone.
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"
#include "tuner/online.h"
#include "tuner/record.h"
#include "tuner/subject.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7104 };

struct duet_online {
    duet_online_def def;
    char variants[PLAN_VARIANTS][DUET_VARIANT];
    uint32_t n_variants;
    online online;
};

duet_online_def duet_default_online_def(void)
{
    return (duet_online_def){.most_extra = 0.1, .cookie = COOKIE};
}

static bool check_modes(const duet_online_def *def, duet_error *err)
{
    for (uint32_t i = 0; i < def->n_modes; ++i)
        if (def->modes[i] >= DUET_MODE_DEFAULT)
            return bad_argument(err, "modes: %d; expected shared, own or slab", (int)def->modes[i]);
    return true;
}

// A motion and a task have nothing but their share to choose.
static bool check_share_alone(const duet_online_def *def, duet_error *err)
{
    const char *other = def->n_modes      ? "modes"
                        : def->n_variants ? "variants"
                        : def->keep       ? "keep"
                                          : NULL;
    return !other || bad_argument(err, "%s: expected none for a %s, whose share alone moves", other,
                                  def->motion ? "motion" : "task");
}

static bool check_motion(const duet_online_def *def, duet_error *err)
{
    if (!motion_is_whole(def->motion, "duet_online_create", err))
        return false;
    if (!def->motion->graph.world)
        return bad_argument(err, "the motion finds no pairs; expected one with contact");
    return check_share_alone(def, err);
}

static bool check_def(const duet_online_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE || !def->world + !def->motion + !def->task != 2)
        return bad_argument(err, "the def comes not from duet_default_online_def, or has no world, "
                                 "motion or task, or several; expected one");
    if (!(def->most_extra >= 0) || !isfinite(def->most_extra))
        return bad_argument(err, "most_extra is %g; expected a part, as 0.1", def->most_extra);
    if (def->task)
        return check_share_alone(def, err);
    if (def->motion)
        return check_motion(def, err);
    return world_is_idle(def->world, "duet_online_create", err) && check_modes(def, err);
}

// ---------------------------------------------------------------- plans

// The place of the variant, which is added if it is new.
static bool list_variant(duet_online *o, const char *name, uint32_t *place, duet_error *err)
{
    for (*place = 0; *place < o->n_variants; ++*place)
        if (strcmp(o->variants[*place], name) == 0)
            return true;
    if (o->n_variants == PLAN_VARIANTS || strlen(name) >= DUET_VARIANT)
        return bad_argument(err,
                            "variant '%.40s': expected at most %d variants, those of the world's "
                            "plan counted, of less than %d characters",
                            name, PLAN_VARIANTS, DUET_VARIANT);
    strcpy(o->variants[o->n_variants++], name);
    return true;
}

static bool list_plan(duet_online *o, listed_plan *plan, duet_error *err)
{
    const duet_plan *own = duet_world_get_plan(o->def.world);
    *plan = (listed_plan){.share = own->share, .mode = own->mode};
    if (!list_variant(o, own->variant_a, &plan->variant[0], err) ||
        !list_variant(o, own->variant_b, &plan->variant[1], err))
        return false;
    for (uint32_t i = 0, place; i < o->def.n_variants; ++i)
        if (!list_variant(o, o->def.variants[i], &place, err))
            return false;
    return true;
}

static duet_plan plan_of(const duet_online *o, const listed_plan *listed)
{
    duet_plan plan = {.share = listed->share, .mode = (duet_mode)listed->mode};
    memcpy(plan.variant_a, o->variants[listed->variant[0]], DUET_VARIANT);
    memcpy(plan.variant_b, o->variants[listed->variant[1]], DUET_VARIANT);
    return plan;
}

static bool step(const duet_online *o, const listed_plan *listed, duet_result *result,
                 search_sample *frame, duet_error *err)
{
    duet_plan plan = plan_of(o, listed);
    if (!duet_world_set_plan(o->def.world, &plan, err) ||
        !duet_world_step(o->def.world, result, err))
        return false;
    *frame = measure_sample(result, &plan);
    return true;
}

// ---------------------------------------------------------------- what plans take

// Runs a frame as if the application had written its objects.
static bool run_listed(void *context, const listed_plan *plan, search_sample *frame)
{
    const duet_online *o = context;
    duet_world *world = o->def.world;
    duet_result result;
    if (!world->resident.mem && world->objects.all.rows == world->objects_block.bytes)
        world_renew_objects(world);
    return step(o, plan, &result, frame, NULL);
}

// A pair that is one device has nothing to share.
static uint32_t modes_of(const duet_online_def *def)
{
    uint32_t modes = def->n_modes ? 0 : (1u << PLAN_MODES) - 1;
    for (uint32_t i = 0; i < def->n_modes; ++i)
        modes |= 1u << def->modes[i];
    return duet_device_pair_is_one(def->world->def.pair) ? 0 : modes;
}

static bool can_be_set(duet_online *o, duet_error *err)
{
    bool ok = true;
    for (uint32_t v = 0; ok && v < o->n_variants; ++v) {
        duet_plan plan = plan_of(o, &(listed_plan){0, DUET_MODE_OWN, {v, v}});
        ok = duet_world_set_plan(o->def.world, &plan, err);
    }
    return ok;
}

// The first step says which mode a plan that leaves it open has, and whether the objects are right.
static bool learn(duet_online *o, duet_error *err)
{
    listed_plan plan;
    duet_result result;
    plan_runner runner = {o, run_listed};
    bool steps = o->def.world->objects.all.n > 0 && duet_world_step(o->def.world, &result, NULL);
    if (!list_plan(o, &plan, err))
        return false;
    bool ok = can_be_set(o, err);
    o->online = online_begin(&plan, o->def.most_extra);
    if (ok && steps)
        plan_times_learn(&o->online.times, o->n_variants, modes_of(&o->def), &runner);
    duet_plan own = plan_of(o, &plan);
    if (!duet_world_set_plan(o->def.world, &own, ok ? err : NULL) || !ok)
        return false;
    if (steps) // the kernels that the first frame has are ready
        duet_world_step(o->def.world, &result, NULL);
    return true;
}

// ---------------------------------------------------------------- open

static bool begin(duet_online *o, duet_error *err)
{
    if (o->def.world)
        return learn(o, err);
    const duet_plan *plan =
        o->def.task ? duet_task_get_plan(o->def.task) : duet_motion_get_plan(o->def.motion);
    o->online = online_begin(&(listed_plan){.share = plan->share}, o->def.most_extra);
    return true;
}

duet_online *duet_online_create(const duet_online_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!check_def(def, err))
        return NULL;
    duet_online *o = calloc(1, sizeof *o);
    if (!o)
        return null_no_memory(err, "a tuning on line");
    o->def = *def;
    if (!begin(o, err)) {
        free(o);
        return NULL;
    }
    if (def->world)
        world_hold(def->world);
    return o;
}

// ---------------------------------------------------------------- frames

// Checks a call of one that follows such a thing, and tells the next frame's plan.
static bool begin_frame(const duet_online *o, const void *followed, const char *name,
                        const void *result, const char *call, listed_plan *plan, duet_error *err)
{
    if (!error_given(o, call, "online", err) || !error_given(result, call, "result", err))
        return false;
    if (!followed)
        return bad_argument(err, "%s: the def had no %s; expected one", call, name);
    return online_plan(&o->online, plan, err);
}

bool duet_online_step(duet_online *o, duet_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    listed_plan plan;
    search_sample frame;
    if (!begin_frame(o, o ? o->def.world : NULL, "world", result, __func__, &plan, err) ||
        !world_is_idle(o->def.world, __func__, err))
        return false;
    bool of_rival = online_is_trial(&o->online);
    if (step(o, &plan, result, &frame, of_rival ? NULL : err))
        return online_tell(&o->online, &frame, err);
    if (!of_rival || !step(o, &o->online.plan, result, &frame, err))
        return false; // by the kept plan, too: the rival is not to blame
    online_refuse(&o->online);
    return online_tell(&o->online, &frame, err);
}

bool duet_online_advance(duet_online *o, duet_motion_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    listed_plan plan;
    duet_result found;
    if (!begin_frame(o, o ? o->def.motion : NULL, "motion", result, __func__, &plan, err) ||
        !motion_is_whole(o->def.motion, __func__, err) ||
        !motion_set_share(o->def.motion, plan.share, err))
        return false;
    motion_take_search(o->def.motion, &found); // from a step that was not this one
    if (!duet_motion_advance(o->def.motion, result, err))
        return false;
    if (!motion_take_search(o->def.motion, &found))
        return true;
    search_sample frame = measure_sample(&found, duet_motion_get_plan(o->def.motion));
    return online_tell(&o->online, &frame, err);
}

bool duet_online_run(duet_online *o, duet_task_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    listed_plan listed;
    if (!begin_frame(o, o ? o->def.task : NULL, "task", result, __func__, &listed, err))
        return false;
    duet_plan plan = *duet_task_get_plan(o->def.task);
    plan.share = listed.share;
    if (!duet_task_set_plan(o->def.task, &plan, err) || !duet_task_run(o->def.task, result, err))
        return false;
    const duet_result times = {.total_ms = result->total_ms,
                               .device_ms = {result->device_ms[0], result->device_ms[1]}};
    search_sample frame = measure_sample(&times, &plan);
    return online_tell(&o->online, &frame, err);
}

// ---------------------------------------------------------------- close

uint32_t duet_online_get_tunings(const duet_online *o)
{
    return o ? o->online.tunings : 0;
}

static bool keep(const duet_online *o, duet_error *err)
{
    profile_subject known;
    record r;
    if (!world_is_idle(o->def.world, "duet_online_destroy", err))
        return false;
    duet_plan plan = plan_of(o, &o->online.plan);
    if (!profile_subject_read(o->def.world, &known, err))
        return false;
    profile_subject_settle(&known, duet_world_get_level(o->def.world));
    profile_request request = profile_subject_request(&known);
    if (!record_open(&r, o->def.store, err))
        return false;
    bool ok = record_aim(&r, &request, err) && record_online(&r, &plan, o->online.total_ns, err);
    record_close(&r);
    return ok;
}

bool duet_online_destroy(duet_online *o, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!o)
        return true;
    bool settled = o->online.tunings > 0 && o->online.state != ONLINE_SETTLING &&
                   o->online.state != ONLINE_MOVING;
    bool ok = !o->def.keep || !settled || keep(o, err);
    online_end(&o->online);
    duet_world_destroy(o->def.world); // NULL for a motion or a task
    free(o);
    return ok;
}
