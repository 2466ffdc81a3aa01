// SPDX-License-Identifier: MIT
// The state that commands left of a domain's bodies, which goes where the bodies go.
#include "runtime/dynamics/domain_commands.h"
#include "base/compare.h"
#include "base/error.h"
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_targets.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { FORCE_FLOATS = 8 };

// The end of a body's state.
typedef struct left_row {
    uint64_t user_data;
    uint32_t place_state, generation;
    uint32_t is_aimed;
    duet_transform target;
    float force[FORCE_FLOATS];
} left_row;

static_assert(sizeof(left_row) == 80, "no byte that travels is left to chance");

size_t domain_command_bytes(const duet_motion *m)
{
    return m->commands ? sizeof(left_row) : 0;
}

static left_row row_of(domain_left left, size_t i)
{
    left_row row;
    memcpy(&row, left.rows + i * left.stride, sizeof row);
    return row;
}

static void put_row(domain_left left, size_t i, const left_row *row)
{
    memcpy(left.rows + i * left.stride, row, sizeof *row);
}

bool domain_left_hidden(const duet_motion *m, domain_left left)
{
    return m->commands && row_of(left, 0).place_state != PLACE_ENABLED;
}

void domain_forget_idle_commands(duet_motion *m)
{
    const motion_commands *c = m->commands;
    bool idle = c && c->n_hidden == 0 && c->n_targets == 0 && c->n_pushed == 0;
    for (uint32_t i = 0; idle && i < m->n; ++i)
        idle = c->generations[i] == 0 && c->user_data[i] == 0;
    if (!idle)
        return;
    motion_forget_commands(m->commands);
    m->commands = NULL;
}

// ---------------------------------------------------------------- reading

static void read_places(const duet_motion *m, domain_left left, const uint32_t *places, uint32_t n)
{
    const motion_commands *c = m->commands;
    for (uint32_t i = 0; i < n; ++i)
        put_row(left, i,
                &(left_row){.user_data = c->user_data[places[i]],
                            .place_state = c->states[places[i]],
                            .generation = c->generations[places[i]]});
}

// Places ascend.
static void read_targets(const duet_motion *m, domain_left left, const uint32_t *places, uint32_t n)
{
    const motion_commands *c = m->commands;
    for (uint32_t i = 0; i < c->n_targets; ++i) {
        const uint32_t *found =
            bsearch(&c->targets[i].place, places, n, sizeof *places, compare_uint32);
        if (!found)
            continue;
        left_row row = row_of(left, (size_t)(found - places));
        row.is_aimed = 1;
        row.target = c->targets[i].pose;
        put_row(left, (size_t)(found - places), &row);
    }
}

static bool read_forces(duet_motion *m, domain_left left, const uint32_t *places, uint32_t n,
                        duet_error *err)
{
    float *forces = malloc((size_t)n * FORCE_FLOATS * sizeof(float) + 1);
    if (!forces)
        return no_memory(err, "the forces on %u bodies", n);
    bool ok = domain_pack_rows(m, FORCES, NULL, places, n, forces, err);
    for (uint32_t i = 0; ok && i < n; ++i) {
        left_row row = row_of(left, i);
        memcpy(row.force, forces + (size_t)i * FORCE_FLOATS, sizeof row.force);
        put_row(left, i, &row);
    }
    free(forces);
    return ok;
}

bool domain_read_commands(duet_motion *m, domain_left left, const uint32_t *places, uint32_t n,
                          duet_error *err)
{
    if (!m->commands || n == 0)
        return true;
    read_places(m, left, places, n);
    read_targets(m, left, places, n);
    return m->commands->n_pushed == 0 || read_forces(m, left, places, n, err);
}

// ---------------------------------------------------------------- taking

static void take_place(motion_commands *c, uint32_t place, const left_row *row)
{
    c->user_data[place] = row->user_data;
    c->generations[place] = row->generation;
    c->states[place] = (uint8_t)row->place_state;
    c->n_hidden += row->place_state != PLACE_ENABLED;
    c->n_left += row->place_state == PLACE_LEFT;
    if (row->place_state == PLACE_EMPTY && place < c->first_empty)
        c->first_empty = place;
    if (row->is_aimed)
        c->targets[c->n_targets++] = (motion_target){place, row->target};
}

static uint32_t count_targets(const duet_motion *m, domain_left left)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < m->n; ++i)
        n += row_of(left, i).is_aimed;
    return n;
}

bool domain_take_commands(duet_motion *m, domain_left left, duet_error *err)
{
    if (!m->commands)
        return true;
    uint32_t n_targets = count_targets(m, left);
    motion_target *targets = malloc((n_targets + 1) * sizeof *targets);
    motion_forget_commands(m->commands);
    m->commands = NULL;
    if (!targets || !motion_begin_commands(m, err)) {
        free(targets);
        return no_memory(err, "commands to %u bodies", m->n);
    }
    m->commands->targets = targets;
    for (uint32_t i = 0; i < m->n; ++i) {
        const left_row row = row_of(left, i);
        take_place(m->commands, i, &row);
    }
    return true;
}

static bool is_pushed(const left_row *row)
{
    bool any = false;
    for (int k = 0; k < FORCE_FLOATS; ++k)
        any = any || row->force[k] != 0.0f;
    return any;
}

// Forces of 0 push nothing.
bool domain_take_forces(duet_motion *m, domain_left left, duet_error *err)
{
    size_t bytes = m->n * FORCE_FLOATS * sizeof(float);
    if (!m->commands || m->n == 0 || !(m->effects & DUET_EFFECT_FORCES))
        return true;
    float *forces = malloc(bytes);
    if (!forces)
        return no_memory(err, "the forces on %u bodies", m->n);
    for (uint32_t i = 0; i < m->n; ++i) {
        const left_row row = row_of(left, i);
        memcpy(forces + (size_t)i * FORCE_FLOATS, row.force, sizeof row.force);
        m->commands->n_pushed += is_pushed(&row);
    }
    bool ok = timeline_write_at(&m->times, "domain", &m->buffers[FORCES], 0, forces, bytes, err) &&
              timeline_finish(&m->times, err);
    free(forces);
    return ok;
}

// ---------------------------------------------------------------- after a step

bool domain_end_commands(duet_motion *m, duet_error *err)
{
    return !m->commands || m->n == 0 ||
           (motion_end_commands(m, err) && motion_arrive(m, err) &&
            timeline_finish(&m->times, err));
}
