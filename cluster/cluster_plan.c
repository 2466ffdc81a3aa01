// SPDX-License-Identifier: MIT
// How the ranks' workers search: their plan, their level, and what the store knows of both; and of
// bodies that move, how often ghosts come.
#include "cluster/cluster.h"

#include "base/error.h"
#include "cluster/moving.h"
#include "runtime/dynamics/motion.h"
#include "runtime/selection/choose_profile.h"

#include <stdio.h>

enum { WEIGHINGS = 2 }; // the time of a step is no straight line

// Each worker's; a profile may have given them others than the def has.
static void read_plans(const duet_cluster *c, duet_plan plans[2])
{
    for (int i = 0; i < cluster_workers(c); ++i)
        plans[i] = c->workers[i]->plan(c->workers[i]);
}

static bool give_plans(duet_cluster *c, const duet_plan plans[2], duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < cluster_workers(c); ++i)
        ok = c->workers[i]->set_plan(c->workers[i], &plans[i], err);
    return ok;
}

bool duet_cluster_set_plan(duet_cluster *c, const duet_plan *plan, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    duet_plan before[2];
    if (!cluster_agree_on(c, __func__, error_given(plan, __func__, "plan", &own), &own, err))
        return false;
    const duet_plan both[2] = {*plan, *plan};
    read_plans(c, before);
    if (!ranks_agree(&c->ranks, give_plans(c, both, &own), &own)) {
        give_plans(c, before, NULL);
        return error_copy(err, &own);
    }
    c->def.world.plan = *plan;
    c->step = STEP_COLD;
    return true;
}

static bool give_level(duet_cluster *c, duet_level level, duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < cluster_workers(c); ++i)
        ok = c->workers[i]->set_level(c->workers[i], level, err);
    return ok;
}

// One level that all ranks ask for and know.
static bool agree_on_level(duet_cluster *c, const char *call, duet_level level, duet_error *err)
{
    tally t = {.greatest = {level, -(double)level}};
    bool ok = duet_level_get_info(level) ||
              bad_argument(err, "level is %d; expected a duet_level", (int)level);
    return ranks_agree_on(&c->ranks, call, ok, &t, err) &&
           (t.greatest[0] + t.greatest[1] == 0 ||
            bad_argument(err, "the ranks' levels differ; expected the same on all"));
}

bool duet_cluster_set_level(duet_cluster *c, duet_level level, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    duet_level before = c->def.world.level;
    bool ok = agree_on_level(c, __func__, level, &own);
    if (ok && !ranks_agree(&c->ranks, give_level(c, level, &own), &own)) {
        give_level(c, before, NULL);
        ok = false;
    }
    if (ok) {
        c->def.world.level = level;
        c->step = STEP_COLD;
    }
    return ok || error_copy(err, &own);
}

static void load_profiles(duet_cluster *c, const char *path, duet_profile *profile,
                          duet_error *store_failed)
{
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    if (owned_count(&c->owned) == 0 || !cluster_show_domain(c, store_failed))
        return;
    for (int i = 0; i < cluster_workers(c); ++i)
        c->workers[i]->load_profile(c->workers[i], path, profile, store_failed);
}

// Weighs ranks by the times that the store knows for the objects that each has now.
static bool weigh_ranks(duet_cluster *c, const duet_profile *profile)
{
    double speed =
        profile->step_ms > 0 ? owned_count(&c->owned) / (c->owned.n_domains * profile->step_ms) : 0;
    if (c->def.weight > 0 || c->ranks.n == 1 || !partition_weigh(&c->partition, &c->ranks, speed))
        return false;
    c->migration.unevenness = 0;
    return true;
}

// ---------------------------------------------------------------- bodies that move

static const char *plural(uint64_t n)
{
    return n == 1 ? "" : "s";
}

void cluster_objective(duet_cluster *c, char objective[CLUSTER_OBJECTIVE])
{
    uint64_t hosts = c->ranks.self_on_host == 0;
    ranks_sum(&c->ranks, &hosts, 1);
    snprintf(objective, CLUSTER_OBJECTIVE, CLUSTER_OVER_RANKS "%d rank%s of %u part%s on %u host%s",
             c->ranks.n, plural(c->ranks.n), c->def.parts, plural(c->def.parts), (unsigned)hosts,
             plural(hosts));
}

// Rank 0 finds it, for all.
typedef struct ghost_choice {
    duet_profile profile;
    uint32_t every; // colours after which ghosts come; 0: the store knows nothing
} ghost_choice;

static void choose_ghosts(const duet_cluster *c, const char *objective, const char *path,
                          ghost_choice *choice, duet_error *err)
{
    const duet_motion *part = moving_get_motion(c->moving, 0);
    motion_plan plan;
    if (part->n > 0 && choose_over_ranks(part, objective, path, &choice->profile, err) &&
        choice->profile.grade != DUET_GRADE_DEFAULT &&
        motion_plan_read(&plan, &choice->profile.plan, &part->device->info, err))
        choice->every = plan.colours;
}

static bool load_motion_profile(duet_cluster *c, const char *path, duet_profile *profile,
                                duet_error *store_failed, duet_error *own)
{
    char objective[CLUSTER_OBJECTIVE];
    ghost_choice choice = {.profile = {.grade = DUET_GRADE_DEFAULT}};
    cluster_objective(c, objective);
    if (c->ranks.self == 0)
        choose_ghosts(c, objective, path, &choice, store_failed);
    ranks_broadcast(&c->ranks, &choice, sizeof choice);
    *profile = choice.profile;
    return choice.every == 0 || moving_set_every(c->moving, choice.every, own);
}

// ---------------------------------------------------------------- what the store knows

bool duet_cluster_load_profile(duet_cluster *c, const char *path, duet_profile *profile,
                               duet_error *store_failed, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    if (store_failed)
        *store_failed = own;
    bool ok = error_given(profile, __func__, "profile", &own);
    if (c->moving)
        return cluster_agree_on(c, __func__, ok, &own, err) &&
               (load_motion_profile(c, path, profile, store_failed, &own) || error_copy(err, &own));
    if (!cluster_settle_all(c, __func__, &own, err))
        return false;
    load_profiles(c, path, profile, store_failed);
    for (int round = 0; round < WEIGHINGS && weigh_ranks(c, profile); ++round) {
        if (!cluster_settle_all(c, __func__, &own, err))
            return false;
        load_profiles(c, path, profile, store_failed);
    }
    c->step = STEP_COLD;
    return true;
}
