// SPDX-License-Identifier: MIT
#include "cli/verified_run.h"

#include "base/error.h"
#include "cli/say.h"
#include "runtime/commands/kept_motion.h"

#include <inttypes.h>

// A motion in which nothing happens has no plan.
static void choose_plan(verified_run *r)
{
    duet_error failure = {0};
    duet_profile profile;
    bool happens = duet_motion_get_count(r->motion) > 0 && duet_motion_get_effects(r->motion) != 0;
    if (happens && !inputs_plan_given(&r->plan) &&
        !duet_motion_load_profile(r->motion, NULL, &profile, &failure))
        say_failed(&failure);
}

bool verified_run_open(verified_run *r, const duet_scene *scene, duet_error *err)
{
    r->pair = inputs_open_pair(r->selectors, err);
    if (!r->pair)
        return false;
    duet_motion_def def = duet_scene_motion_def(scene, r->pair);
    if (!inputs_change_plan(&r->plan, r->pair, r->selectors, &def.plan, err))
        return false;
    r->motion = duet_motion_create_from_scene(&def, scene, NULL, err);
    if (r->motion)
        choose_plan(r);
    if (r->motion && r->path)
        r->replay = duet_replay_create(r->path, err);
    return r->motion && (r->replay || !r->path);
}

void verified_run_close(verified_run *r)
{
    duet_replay_destroy(r->replay);
    duet_motion_destroy(r->motion);
    duet_device_pair_destroy(r->pair);
    text_free(&r->kept);
}

bool verified_run_command(verified_run *r, duet_error *err)
{
    r->commanded = false;
    return !r->replay || replay_give(r->replay, r->motion, &r->commanded, err);
}

// A recorded hash that differs is told after the states of the two runs are compared.
bool verified_run_step(verified_run *r, duet_error *err)
{
    duet_error why = {0};
    if (!r->replay)
        return duet_motion_advance(r->motion, &r->last, err);
    if (duet_replay_advance(r->replay, r->motion, &r->last, &why))
        return true;
    if (why.status != DUET_STATUS_WRONG_RESULT)
        return error_copy(err, &why);
    r->unlike = why;
    return true;
}

bool verified_run_keep(verified_run *r, duet_error *err)
{
    if (r->replay)
        r->kept_place = replay_get_place(r->replay);
    return motion_keep(r->motion, &r->kept, err);
}

bool verified_run_return(verified_run *r, duet_error *err)
{
    if (r->replay)
        replay_set_place(r->replay, &r->kept_place);
    return motion_return(r->motion, &r->kept, err);
}

bool verified_run_sum(verified_run *r, duet_error *err)
{
    r->not_finite = (duet_error){0};
    return duet_motion_get_hash(r->motion, &r->hash, &r->not_finite) ||
           r->not_finite.status == DUET_STATUS_BAD_OBJECT || error_copy(err, &r->not_finite);
}

duet_plan verified_run_plan(const verified_run *r)
{
    const duet_plan *of_pairs = duet_motion_get_plan(r->motion);
    duet_plan plan = of_pairs ? *of_pairs : duet_default_plan(r->pair);
    plan.share = of_pairs ? plan.share : 0;
    return plan;
}

void verified_run_tell(const verified_run *r, text *to)
{
    if (r->ranks > 0) {
        text_add(to, "%" PRIu64 " %s", r->ranks, r->ranks == 1 ? "rank" : "ranks");
        return;
    }
    duet_plan plan = verified_run_plan(r);
    const char *a = duet_device_pair_get_info(r->pair, 0)->selector;
    const char *b = duet_device_pair_get_info(r->pair, 1)->selector;
    if (plan.share == 0)
        text_add(to, "%s", b);
    else
        text_add(to, "%s,%s (share %.4g, %s)", a, b, plan.share / (double)DUET_SHARE_ONE,
                 duet_mode_name(plan.mode));
}
