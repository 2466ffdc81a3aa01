// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_targets.h"

#include "base/error.h"
#include "runtime/dynamics/motion_state.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

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
        no_memory(err, "%u places", m->n);
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

// The pose is within the origin cells: the command, or the reader of a file, that set the target
// saw that.
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
        return no_memory(err, "%u targets", n);
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

// Contacts of places that bodies left end once pairs are searched.
bool motion_end_commands(duet_motion *m, duet_error *err)
{
    const motion_commands *c = m->commands;
    const bool waits = product_is_forgotten(&m->products, PRODUCT_PAIRS);
    if (c->n_left > 0 && (!waits || !(m->effects & DUET_EFFECT_CONTACT)))
        empty_places(m);
    return c->n_pushed == 0 || forget_forces(m, err);
}
