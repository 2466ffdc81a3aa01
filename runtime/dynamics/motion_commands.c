// SPDX-License-Identifier: MIT
// What commands leave to a step: places and ids, targets, and forces.
#include "runtime/dynamics/motion_commands.h"
#include "base/error.h"
#include "base/text.h"
#include "runtime/narrowphase/origin.h"

#include <assert.h>
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
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for commands to %u objects", m->n);
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

bool duet_motion_get_ids(const duet_motion *m, uint32_t first, uint32_t n, uint64_t *ids,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(m, __func__, "motion", err) ||
        (n > 0 && !error_given(ids, __func__, "ids", err)))
        return false;
    if (first > m->n || n > m->n - first)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: places %u to %llu; the motion has %u places", __func__, first,
                         (unsigned long long)first + n, m->n);
    for (uint32_t i = 0; i < n; ++i)
        ids[i] = motion_has_place(m, first + i) ? motion_id_at(m, first + i) : DUET_NO_BODY;
    return true;
}

// ---------------------------------------------------------------- effects

bool motion_lacks(uint32_t missing, const char *call, const char *who, duet_error *err)
{
    for (uint32_t i = 0; effect_at(i); ++i)
        if (missing & effect_at(i)->effect)
            return !error_set(err, DUET_STATUS_BAD_ARGUMENT,
                              "%s: %s needs the effect %s; expected the motion's wants to ask for "
                              "it",
                              call, who, effect_at(i)->name);
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

// ---------------------------------------------------------------- targets

duet_pose motion_aim(const duet_motion *m, duet_pose pose, const duet_transform *target)
{
    bool solid = m->def.dims == 3;
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = k < (int)m->def.dims ? target->centre[k] : 0.0f;
    for (int k = 0; k < 4; ++k)
        pose.rotation[k] = solid || k >= 2 ? target->rotation[k] : 0.0f;
    return pose;
}

bool motion_forget_targets(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_commands *c = m->commands;
    if (c->n_targets == 0)
        return true;
    uint8_t *named = calloc((size_t)m->n + 1, 1);
    uint32_t *stopped = malloc((size_t)c->n_targets * sizeof *stopped);
    uint32_t n_kept = 0, n_stopped = 0;
    bool ok = named && stopped;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u places", m->n);
    for (uint32_t i = 0; ok && i < n; ++i)
        named[places[i]] = 1;
    for (uint32_t i = 0; ok && i < c->n_targets; ++i) {
        if (named[c->targets[i].place])
            stopped[n_stopped++] = c->targets[i].place;
        else
            c->targets[n_kept++] = c->targets[i];
    }
    for (uint32_t i = 0; i < n_stopped; ++i)
        motion_stop(m, stopped[i]);
    if (ok) {
        c->n_targets = n_kept;
        ok = motion_keep_whole(m, motion_send_places(m, stopped, n_stopped,
                                                     PART_VELOCITY | PART_ANGULAR_VELOCITY, err));
    }
    free(stopped);
    free(named);
    return ok;
}

// What set a target saw that its pose is within the origin cells: a command, or a file's reader.
static void put_at(duet_motion *m, const motion_target *t)
{
    cl_int4 cell = {{0}};
    duet_pose pose = motion_aim(m, m->poses[t->place], &t->pose);
    if (m->cells) {
        bool is_in_cells = motion_place_pose(m, &pose, &cell);
        assert(is_in_cells);
        (void)is_in_cells;
        m->cells[t->place] = cell;
    }
    m->poses[t->place] = pose;
    motion_stop(m, t->place);
}

bool motion_arrive(duet_motion *m, duet_error *err)
{
    motion_commands *c = m->commands;
    uint32_t n = c->n_targets;
    if (n == 0)
        return true;
    uint32_t *places = malloc(n * sizeof *places);
    if (!places)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u targets", n);
    for (uint32_t i = 0; i < n; ++i) {
        places[i] = c->targets[i].place;
        put_at(m, &c->targets[i]);
    }
    c->n_targets = 0;
    bool ok =
        motion_send_places(m, places, n, PART_POSE | PART_VELOCITY | PART_ANGULAR_VELOCITY, err) &&
        motion_wake_places(m, places, n, err); // objects that bodies reach have not felt them yet
    free(places);
    return ok;
}

// ---------------------------------------------------------------- after a step

static bool forget_forces(duet_motion *m, duet_error *err)
{
    m->commands->n_pushed = 0;
    return motion_clear(m, "clear", FORCES, 0, (size_t)m->n * 8, err);
}

// A place whose ids are used up is never empty again.
static void empty_places(duet_motion *m)
{
    motion_commands *c = m->commands;
    c->n_left = 0;
    for (uint32_t place = m->n; place-- > 0;) {
        if (c->states[place] != PLACE_LEFT || c->generations[place] == 0)
            continue;
        c->states[place] = PLACE_EMPTY;
        c->first_empty = place < c->first_empty ? place : c->first_empty;
    }
}

bool motion_end_commands(duet_motion *m, duet_error *err)
{
    motion_commands *c = m->commands;
    if (c->n_left > 0 && (!motion_rows_are_stale(m) || !(m->effects & DUET_EFFECT_CONTACT)))
        empty_places(m);
    return c->n_pushed == 0 || forget_forces(m, err);
}
