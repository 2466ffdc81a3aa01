// SPDX-License-Identifier: MIT
// What may be chosen of a motion that is there: another plan, and the values that its kernels'
// parameters and its skin may have.
#include "runtime/dynamics/motion.h"

#include "base/error.h"
#include "runtime/broadphase/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- a plan

// After a failure the motion has the plan before.
static bool prepare_with(duet_motion *m, const motion_plan *plan, duet_error *err)
{
    const motion_plan before = m->plan;
    m->plan = *plan;
    if (motion_prepare_again(m, err)) {
        if (plan->skin != before.skin)
            motion_alter_all(m);
        return true;
    }
    m->plan = before;
    return false;
}

// Returns the plan as it was given: a mode that is left to the grid stays so.
static duet_plan plan_of(const duet_world *world)
{
    duet_plan plan = world->def.plan;
    plan.mode = world->asked_mode;
    return plan;
}

bool duet_motion_set_plan(duet_motion *m, const duet_plan *plan, duet_error *err)
{
    PUBLIC_CALL(err);
    motion_plan read;
    if (!motion_is_whole(m, __func__, err) || !error_given(plan, __func__, "plan", err) ||
        !motion_plan_read(&read, plan, &m->device->info, err))
        return false;
    const duet_plan before = m->graph.world ? plan_of(m->graph.world) : m->plan.search;
    if (m->graph.world && !duet_world_set_plan(m->graph.world, &read.search, err))
        return false;
    bool ok = prepare_with(m, &read, err);
    if (!ok && m->graph.world)
        duet_world_set_plan(m->graph.world, &before, NULL);
    motion_plan_note(m);
    return ok;
}

bool motion_set_share(duet_motion *m, uint32_t share, duet_error *err)
{
    duet_plan plan = plan_of(m->graph.world);
    plan.share = share;
    if (!duet_world_set_plan(m->graph.world, &plan, err))
        return false;
    m->plan.search.share = share;
    motion_plan_note(m);
    return true;
}

// ---------------------------------------------------------------- what is free

static const int64_t skins[] = {0, 5, 10, 20, 40, 80}; // in percent; 0: the def's

enum { N_SKINS = sizeof skins / sizeof skins[0] };

// The one that the motion has built; NULL if it has none of that name.
static const kernel *find_kernel(const duet_motion *m, const char *name)
{
    for (int i = 0; i < MOTION_KERNELS; ++i)
        if (kernel_is(m->kernels.of[i], name))
            return m->kernels.of[i];
    return NULL;
}

// Varied like a kernel's parameter: what a skin takes and saves is in these stages.
static kernel_space space_of_skin(const duet_motion *m)
{
    kernel_space space = {.stages = {"pairs", "contact_graph", "manifolds"}, .n_params = 1};
    snprintf(space.kernel, sizeof space.kernel, "%s", MOTION_PLAN_WORD);
    snprintf(space.params[0].name, sizeof space.params[0].name, "skin");
    memcpy(space.params[0].values, skins, sizeof skins);
    space.params[0].n_values = space.n_configs = N_SKINS;
    for (uint8_t i = 0; i < N_SKINS; ++i) {
        space.configs[i][0] = i;
        space.now = skins[i] == m->plan.skin ? i : space.now;
    }
    return space;
}

bool motion_kernel_spaces(duet_motion *m, kernel_spaces *to, duet_error *err)
{
    const kernel_space skin = space_of_skin(m);
    if ((m->effects & DUET_EFFECT_SKIN) && !kernel_spaces_add(to, &skin, err))
        return false;
    gen_offer offers[MOTION_OFFERS + 2];
    uint32_t n_offers = motion_offers(m, false, offers);
    // Kernels that share the blocks have one size of them.
    offers[n_offers++] = (gen_offer){NULL, "BLOCK", m->layout.block, GEN_OFFERED, NULL};
    if (m->kernels.of[PREPARE_CONTACTS])
        offers[n_offers++] =
            (gen_offer){"prepare_contacts", "LANES",
                        kernel_param(m->kernels.of[PREPARE_CONTACTS], "LANES"), GEN_OFFERED, NULL};
    const kernel_space_source from = {m->gen, program_set_limits(m->programs), offers, n_offers};
    bool ok = true;
    for (int i = 0; ok && i < MOTION_PLAN_KERNELS; ++i) {
        const kernel *k = find_kernel(m, motion_plan_kernels[i].name);
        ok = !k || kernel_space_read(&from, motion_plan_kernels[i].name,
                                     motion_plan_kernels[i].stages, k, to, err);
    }
    return ok;
}
