// SPDX-License-Identifier: MIT
#include "runtime/dynamics/team.h"

#include "runtime/dynamics/motion.h"

// Numbers of stages begin anew before they have no next one.
static bool reserve_stages(duet_motion *m, uint32_t n_stages, duet_error *err)
{
    motion_team *t = &m->team;
    if (t->stage > 0 && t->stage < UINT32_MAX - n_stages)
        return true;
    t->stage = 0;
    return motion_reserve(m, TEAM, TEAM_WORDS, sizeof(uint32_t), err) &&
           motion_clear(m, "clear", TEAM, 0, TEAM_WORDS, err);
}

// Work-items for which a unit of a GPU surely has registers: each takes 255 of 65 536 at most. In a
// caller's context another motion may have groups on it that meet, too, and takes the other half.
enum { RESIDENT = 256 };

uint32_t team_most_groups(const duet_motion *m, const kernel *k)
{
    const uint32_t units = m->device->info.units;
    const uint32_t resident = m->device->callers ? RESIDENT / 2 : RESIDENT;
    const uint32_t each = k->group > 1 && k->group < resident ? resident / k->group : 1;
    return units * each < TEAM_MOST ? units * each : TEAM_MOST;
}

static uint32_t count_groups(const duet_motion *m, const kernel *k, uint64_t work, uint32_t least)
{
    const uint64_t parts = (work + least - 1) / least;
    const uint32_t most = team_most_groups(m, k);
    return parts == 0 ? 1 : parts < most ? (uint32_t)parts : most;
}

bool team_launch(duet_motion *m, motion_kernel which, uint64_t work, uint32_t least,
                 uint32_t n_stages, duet_error *err)
{
    const kernel *k = m->kernels.of[which];
    uint32_t n_groups = count_groups(m, k, work, least);
    if (!reserve_stages(m, n_stages, err) ||
        !motion_launch_over(m, which, (uint64_t)n_groups * k->group * k->per_item, err))
        return false;
    m->team.stage += n_stages;
    return true;
}
