// SPDX-License-Identifier: MIT
#include "cli/verified_run.h"

#include "base/error.h"
#include "runtime/commands/kept_motion.h"

#include <inttypes.h>

bool verified_run_open(verified_run *r, const duet_scene *scene, duet_error *err)
{
    r->pair = inputs_open_pair(r->selectors, err);
    if (!r->pair)
        return false;
    duet_profile profile;
    duet_motion_def def = duet_scene_motion_def(scene, r->pair);
    r->motion = inputs_make_motion(scene, &def, r->selectors, &r->plan, &profile, err);
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

void verified_run_tell(const verified_run *r, text *to)
{
    if (r->ranks > 0) {
        text_add(to, "%" PRIu64 " %s", r->ranks, r->ranks == 1 ? "rank" : "ranks");
        return;
    }
    const duet_plan plan = inputs_motion_plan(r->motion);
    const char *a = duet_device_pair_get_info(r->pair, 0)->selector;
    const char *b = duet_device_pair_get_info(r->pair, 1)->selector;
    if (plan.share == 0)
        text_add(to, "%s", b);
    else
        text_add(to, "%s,%s (share %.4g, %s)", a, b, plan.share / (double)DUET_SHARE_ONE,
                 duet_mode_name(plan.mode));
}
