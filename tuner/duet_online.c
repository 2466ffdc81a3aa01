// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/selection/profile_subject.h"
#include "tuner/measure.h"
#include "tuner/online.h"
#include "tuner/record.h"

#include <math.h>
#include <stdlib.h>

enum { COOKIE = 0x0d0e7004 };

struct duet_online {
    duet_online_def def;
    online online;
};

duet_online_def duet_default_online_def(void)
{
    return (duet_online_def){.most_extra = 0.1, .cookie = COOKIE};
}

duet_online *duet_online_create(const duet_online_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE || !def->world) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT,
                  "the def has no world or does not come from duet_default_online_def");
        return NULL;
    }
    if (!(def->most_extra >= 0) || !isfinite(def->most_extra)) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT, "most_extra is %g; expected a part, as 0.1",
                  def->most_extra);
        return NULL;
    }
    duet_online *o = calloc(1, sizeof *o);
    if (!o) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory to tune on line");
        return NULL;
    }
    o->def = *def;
    world_hold(def->world);
    o->online = online_begin(duet_world_get_plan(def->world)->share, def->most_extra);
    return o;
}

bool duet_online_step(duet_online *o, duet_result *result, duet_error *err)
{
    if (!error_given(o, __func__, "online", err) || !error_given(result, __func__, "result", err))
        return false;
    duet_plan plan = *duet_world_get_plan(o->def.world);
    if (!online_share(&o->online, &plan.share, err) ||
        !duet_world_set_plan(o->def.world, &plan, err) ||
        !duet_world_step(o->def.world, result, err))
        return false;
    search_sample frame = measure_sample(result, &plan);
    return online_tell(&o->online, &frame, err);
}

uint32_t duet_online_get_tunings(const duet_online *o)
{
    return o ? o->online.tunings : 0;
}

static bool keep(const duet_online *o, duet_error *err)
{
    profile_subject known;
    record r;
    duet_plan plan = *duet_world_get_plan(o->def.world);
    plan.share = o->online.share;
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
    if (!o)
        return true;
    bool settled = o->online.tunings > 0 && o->online.state == ONLINE_WATCHING;
    bool ok = !o->def.keep || !settled || keep(o, err);
    online_end(&o->online);
    duet_world_destroy(o->def.world);
    free(o);
    return ok;
}
