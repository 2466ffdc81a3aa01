// SPDX-License-Identifier: MIT
// A cluster's motion, for its callers.
#include "cluster/cluster.h"

#include "base/error.h"
#include "cluster/moving.h"
#include "cluster/moving_commands.h"
#include "runtime/commands/commands.h"

#include <stdlib.h>

static void end_motion(duet_cluster *c)
{
    moving_end(c->moving);
    c->moving = NULL;
}

bool duet_cluster_begin_motion(duet_cluster *c, const char *path, const duet_setting *settings,
                               uint32_t n_settings, const char *resume, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_error own = {0};
    if (!error_given(c, __func__, "cluster", err))
        return false;
    bool ok = error_given(path, __func__, "path", &own);
    if (ok && !c->def.world.pair)
        ok = bad_argument(&own, "a cluster of plain workers moves nothing; expected devices");
    if (!cluster_agree_on(c, __func__, ok, &own, err))
        return false;
    end_motion(c);
    c->moving = moving_begin(&c->ranks,
                             &(moving_start){.path = path,
                                             .settings = settings,
                                             .n_settings = n_settings,
                                             .resume = resume,
                                             .pair = c->def.world.pair,
                                             .plan = &c->def.world.plan,
                                             .parts = c->def.parts},
                             &own);
    return c->moving || error_copy(err, &own);
}

uint64_t duet_cluster_get_motion_step(const duet_cluster *c)
{
    return c && c->moving ? moving_get_counts(c->moving).step : 0;
}

// Fails on all ranks if one has no motion.
static bool begin_call(duet_cluster *c, const char *call, const void *argument, const char *name,
                       duet_error *own, duet_error *err)
{
    bool ok = error_given(argument, call, name, own);
    if (ok && !c->moving)
        ok = bad_argument(own, "%s: nothing moves; expected duet_cluster_begin_motion first", call);
    return cluster_agree_on(c, call, ok, own, err);
}

bool duet_cluster_advance(duet_cluster *c, duet_cluster_motion_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_error own = {0};
    if (!error_given(c, __func__, "cluster", err) ||
        !begin_call(c, __func__, result, "result", &own, err))
        return false;
    uint64_t begun_ns = ranks_now_ns();
    if (!moving_step(c->moving, &own)) {
        end_motion(c);
        return error_copy(err, &own);
    }
    moving_counts counts = moving_get_counts(c->moving);
    double total_ms = ranks_greatest(&c->ranks, (double)(ranks_now_ns() - begun_ns) * 1e-6);
    const moving_told told = moving_get_told(c->moving);
    *result = (duet_cluster_motion_result){.step = counts.step,
                                           .bodies = counts.bodies,
                                           .ghosts = counts.ghosts,
                                           .contacts = counts.contacts,
                                           .colours = counts.colours,
                                           .total_ms = total_ms,
                                           .slowest_ms = counts.slowest_ms,
                                           .mean_ms = counts.mean_ms,
                                           .slowest_rank = counts.slowest_rank,
                                           .events = told.changes->events,
                                           .n_events = told.changes->n_events,
                                           .stays = told.changes->stays.pairs,
                                           .n_stays = told.changes->stays.n,
                                           .hits = told.hits,
                                           .n_hits = told.n_hits};
    return true;
}

bool duet_cluster_get_state_hash(duet_cluster *c, uint64_t *hash, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_error own = {0};
    return error_given(c, __func__, "cluster", err) &&
           begin_call(c, __func__, hash, "hash", &own, err) &&
           (moving_hash(c->moving, hash, &own) || error_copy(err, &own));
}

bool duet_cluster_save_motion(duet_cluster *c, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_error own = {0};
    return error_given(c, __func__, "cluster", err) &&
           begin_call(c, __func__, path, "path", &own, err) &&
           (moving_save(c->moving, path, &own) || error_copy(err, &own));
}

// ---------------------------------------------------------------- commands

bool cluster_give(duet_cluster *c, command *k, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_error own = {0};
    k->call = k->op->cluster_call;
    if (!error_given(c, k->call, "cluster", err))
        return false;
    if (c->ranks.self == 0)
        command_check_given(k, &own);
    if (!begin_call(c, k->call, c, "cluster", &own, err))
        return false;
    given_command given = moving_give(c->moving, k, &own);
    if (given == COMMAND_BROKE)
        end_motion(c);
    return given == COMMAND_DONE || error_copy(err, &own);
}

#define GIVE(number, ...)                                                                  \
    {                                                                                      \
        return cluster_give(c, &(command){.op = command_op_at(number), __VA_ARGS__}, err); \
    }
#define CALL(name) duet_cluster_##name
#define SUBJECT duet_cluster *c
#include "runtime/commands/command_calls.inl"

const duet_motion_def *duet_cluster_get_motion_def(const duet_cluster *c)
{
    return c && c->moving ? moving_get_def(c->moving) : NULL;
}

bool duet_cluster_get_user_data(duet_cluster *c, duet_body_list list, uint64_t *data,
                                duet_error *err)
{
    PUBLIC_CALL(err);
    duet_error own = {0};
    uint64_t *all = NULL;
    uint32_t n = 0;
    bool asks = list.n > 0;
    if (!error_given(c, __func__, "cluster", err) ||
        !begin_call(c, __func__, asks ? (const void *)data : c, "data", &own, err))
        return false;
    bool ok = moving_get_user_data(c->moving, list, __func__, &all, &n, &own);
    for (uint32_t i = 0; ok && i < n && i < list.n; ++i)
        data[i] = all[i];
    free(all);
    return ok || error_copy(err, &own);
}
