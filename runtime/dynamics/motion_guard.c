// SPDX-License-Identifier: MIT
// What a public call asks of a motion first: that no step is under way or left half-way, and that
// nothing of its state is mapped.
#include "runtime/dynamics/motion_commands.h"

#include "base/error.h"
#include "runtime/duet_motion_map.h"

bool motion_is_idle(const duet_motion *m, const char *call, duet_error *err)
{
    return !m->background.under_way ||
           error_set(
               err, DUET_STATUS_BAD_ARGUMENT,
               "%s: a step of the motion is under way; expected duet_motion_advance_end first",
               call);
}

bool motion_is_steady(const duet_motion *m, const char *call, duet_error *err)
{
    return error_given(m, call, "motion", err) && motion_is_idle(m, call, err) &&
           (!m->broken ||
            error_set(err, DUET_STATUS_BAD_ARGUMENT,
                      "the motion failed in its step %llu; expected a saved one to be loaded, or a "
                      "new motion",
                      (unsigned long long)m->step + 1));
}

bool motion_is_unmapped(const duet_motion *m, const char *call, duet_error *err)
{
    for (uint32_t part = 0; m->mapped >> part; ++part)
        if (m->mapped >> part & 1u)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: %s are mapped; expected duet_motion_unmap_states first", call,
                             duet_state_part_name((duet_state_part)part));
    return true;
}

bool motion_is_whole(const duet_motion *m, const char *call, duet_error *err)
{
    return motion_is_steady(m, call, err) && motion_is_unmapped(m, call, err);
}

bool motion_keep_whole(duet_motion *m, bool made)
{
    m->broken = m->broken || !made;
    return made;
}
