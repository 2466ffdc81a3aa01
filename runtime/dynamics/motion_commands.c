// SPDX-License-Identifier: MIT
// The state that commands leave behind: its owner, ids, effects that commands call for, and given
// poses.
#include "runtime/dynamics/motion_commands.h"
#include "base/error.h"
#include "base/text.h"
#include "runtime/narrowphase/origin.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- owner

bool motion_begin_commands(duet_motion *m, duet_error *err)
{
    size_t n = m->n;
    if (m->commands)
        return true;
    motion_commands *c = calloc(1, sizeof *c);
    if (c)
        *c = (motion_commands){.capacity = m->n,
                               .first_empty = m->n,
                               .generations = calloc(n + 1, sizeof *c->generations),
                               .states = malloc(n + 1),
                               .user_data = calloc(n + 1, sizeof *c->user_data)};
    if (!c || !c->generations || !c->states || !c->user_data) {
        motion_forget_commands(c);
        return no_memory(err, "commands to %u objects", m->n);
    }
    memset(c->states, PLACE_ENABLED, n);
    m->commands = c;
    return true;
}

void motion_forget_commands(motion_commands *c)
{
    if (!c)
        return;
    free(c->generations);
    free(c->states);
    free(c->user_data);
    free(c->targets);
    free(c);
}

void motion_forget_recording(duet_motion *m)
{
    if (m->recording)
        text_free(m->recording);
    free(m->recording);
    m->recording = NULL;
}

// ---------------------------------------------------------------- ids

bool duet_motion_has_body(const duet_motion *m, uint64_t id)
{
    uint32_t place = (uint32_t)id;
    return m && place < m->n && motion_id_at(m, place) == id && motion_has_place(m, place);
}

bool motion_has_range(const duet_motion *m, uint32_t first, uint32_t n, const char *call,
                      duet_error *err)
{
    return (first <= m->n && n <= m->n - first) ||
           bad_argument(err, "%s: places %u to %llu; the motion has %u places", call, first,
                        (unsigned long long)first + n, m->n);
}

bool duet_motion_get_ids(const duet_motion *m, uint32_t first, uint32_t n, uint64_t *ids,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(m, __func__, "motion", err) ||
        (n > 0 && !error_given(ids, __func__, "ids", err)) ||
        !motion_has_range(m, first, n, __func__, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        ids[i] = motion_has_place(m, first + i) ? motion_id_at(m, first + i) : DUET_NO_BODY;
    return true;
}

// ---------------------------------------------------------------- effects

bool motion_lacks(uint32_t missing, const char *call, const char *who, duet_error *err)
{
    for (uint32_t i = 0; effect_at(i); ++i)
        if (missing & effect_at(i)->effect)
            return !bad_argument(
                err, "%s: %s needs the effect %s; expected the motion's wants to ask for it", call,
                who, effect_at(i)->name);
    return false;
}

bool motion_needs(const duet_motion *m, uint32_t effect, const char *call, duet_error *err)
{
    return !motion_lacks(effect & ~m->effects, call, "it", err);
}

// ---------------------------------------------------------------- poses

void motion_stop(duet_motion *m, uint32_t place)
{
    memset(m->bodies[place].velocity, 0, sizeof m->bodies[place].velocity);
    memset(m->bodies[place].angular_velocity, 0, sizeof m->bodies[place].angular_velocity);
}

bool motion_place_pose(const duet_motion *m, duet_pose *pose, cl_int4 *cell)
{
    duet_large_pose p = {.pose = *pose};
    double at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = m->def.origin[k] + (double)pose->centre[k];
    bool ok = origin_place(&p, at, m->def.origin_edge);
    *pose = p.pose;
    memcpy(cell->s, p.cell, m->def.dims * sizeof *p.cell);
    return ok;
}
