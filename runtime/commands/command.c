// SPDX-License-Identifier: MIT
#include "runtime/commands/command.h"

#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

// ---------------------------------------------------------------- places

static uint64_t id_of(const duet_body_list *list, uint32_t i)
{
    return list->ids ? list->ids[i] : list->first + (uint64_t)i;
}

bool command_check_id(const command *c, uint32_t i, uint32_t n_places, duet_error *err)
{
    uint64_t id = id_of(&c->list, i);
    if (id != DUET_NO_BODY && (c->list.ids ? (uint32_t)id : id) < n_places)
        return true;
    return command_fail(c, i, DUET_STATUS_BAD_ARGUMENT, err,
                        "there is no body %llu; the motion has %u places", (unsigned long long)id,
                        n_places);
}

// A domain's place is not the one that the id tells.
bool command_check_place(const duet_motion *m, const command *c, uint32_t i, uint32_t place,
                         duet_error *err)
{
    uint64_t named = id_of(&c->list, i), high = motion_id_at(m, place) & ~(uint64_t)UINT32_MAX,
             id = c->list.ids ? named : high | named;
    bool removed = !motion_has_place(m, place) || (id & ~(uint64_t)UINT32_MAX) != high;
    if (!removed && (c->op->bodies == COMMAND_ANY || !motion_is_hidden(m, place)))
        return true;
    return command_fail(c, i, DUET_STATUS_BAD_ARGUMENT, err, "the body with id %llu %s",
                        (unsigned long long)id, removed ? "was removed" : "is disabled");
}

static bool find_places(const duet_motion *m, command *c, duet_error *err)
{
    const duet_body_list *list = &c->list;
    bool ok = true;
    for (uint32_t i = 0; ok && i < list->n; ++i) {
        c->places[i] = (uint32_t)id_of(list, i);
        ok = command_check_id(c, i, m->n, err) && command_check_place(m, c, i, c->places[i], err);
        if (ok && c->ids)
            c->ids[i] = motion_id_at(m, c->places[i]);
    }
    return ok;
}

bool command_open(duet_motion *m, command *c, duet_error *err)
{
    const size_t n = c->list.n;
    if (!motion_is_whole(m, c->call, err) || !timeline_finish(&m->times, err))
        return false;
    bool listed = command_has_list(c->op);
    bool recorded = listed && m->recording;
    c->places = malloc(n * sizeof *c->places + 1);
    c->ids = recorded ? malloc(n * sizeof *c->ids + 1) : NULL;
    if (!c->places || (recorded && !c->ids))
        return no_memory(err, "%zu places in %s", n, c->call);
    return (!listed || find_places(m, c, err)) && motion_begin_commands(m, err);
}

void command_close(command *c)
{
    motion_rows_drop(&c->pushed.forces);
    motion_rows_drop(&c->pushed.velocities);
    motion_rows_drop(&c->pushed.angular_velocities);
    motion_rows_drop(&c->pushed.rotations);
    motion_rows_drop(&c->pushed.inertias);
    free(c->cells);
    free(c->bodies);
    free(c->poses);
    free(c->places);
    free(c->ids);
}

bool command_fail(const command *c, uint32_t i, duet_status status, duet_error *err,
                  const char *format, ...)
{
    char fault[256];
    va_list values;
    va_start(values, format);
    vsnprintf(fault, sizeof fault, format, values);
    va_end(values);
    if (c->blamed)
        *c->blamed = c->of[i];
    return error_set(err, status, "%s: body %u of %u: %s", c->call, c->of ? c->of[i] : i,
                     command_count(c), fault);
}

// ---------------------------------------------------------------- copies

bool command_copy(const duet_motion *m, command *c, duet_error *err)
{
    const uint32_t n = c->list.n;
    const duet_pose *coming = c->op->form == COMMAND_ADD ? c->rows : NULL;
    c->poses = malloc(n * sizeof *c->poses + 1);
    c->bodies = malloc(n * sizeof *c->bodies + 1);
    if (!c->poses || !c->bodies)
        return no_memory(err, "%u bodies in %s", n, c->call);
    for (uint32_t i = 0; i < n; ++i) {
        c->poses[i] = coming ? coming[i] : m->poses[c->places[i]];
        if (!coming)
            c->bodies[i] = m->bodies[c->places[i]];
        else
            c->bodies[i] = c->new_bodies ? c->new_bodies[i] : duet_default_body();
    }
    return true;
}

bool command_refuse(const command *c, uint32_t i, const char *fault, duet_error *err)
{
    return command_fail(c, i, DUET_STATUS_BAD_OBJECT, err, "%s", fault);
}

bool command_check(const duet_motion *m, const command *c, uint32_t parts, duet_error *err)
{
    for (uint32_t i = 0; i < c->list.n; ++i) {
        const char *fault = NULL;
        if (parts & PART_POSE)
            fault = motion_pose_fault(&c->poses[i], m->def.dims);
        if (!fault && (parts & ~(uint32_t)PART_POSE))
            fault = motion_body_fault(&m->def, &c->bodies[i]);
        if (fault)
            return command_refuse(c, i, fault, err);
    }
    return true;
}

bool command_settle(const duet_motion *m, command *c, duet_error *err)
{
    const uint32_t n = c->list.n;
    if (!m->cells)
        return true;
    c->cells = calloc((size_t)n + 1, sizeof *c->cells);
    if (!c->cells)
        return no_memory(err, "%u cells in %s", n, c->call);
    for (uint32_t i = 0; i < n; ++i)
        if (!motion_place_pose(m, &c->poses[i], &c->cells[i]))
            return command_fail(c, i, DUET_STATUS_BAD_OBJECT, err,
                                "it is beyond 2^30 origin cells of edge %g",
                                (double)m->def.origin_edge);
    return true;
}

void command_keep_poses(duet_motion *m, const command *c)
{
    for (uint32_t i = 0; i < c->list.n; ++i) {
        m->poses[c->places[i]] = c->poses[i];
        if (c->cells)
            m->cells[c->places[i]] = c->cells[i];
    }
}

// ---------------------------------------------------------------- effects

// Adds bodies to what is known of all, and returns the effects that the motion then lacks. How fast
// they are is not looked at: continuous is called for by what a motion begins with.
static uint32_t missing_with(const duet_motion *m, effect_facts *all, const command *c,
                             uint32_t first, uint32_t n)
{
    effect_facts_add(all, &m->def, c->poses + first, c->bodies + first, n);
    *all = effect_facts_as_fast(*all, m->facts);
    return effect_infer(&m->def, *all) & ~m->effects;
}

// A body may call for an effect only together with the bodies before it.
static bool name_who_lacks(const duet_motion *m, const command *c, effect_facts all,
                           duet_error *err)
{
    for (uint32_t i = 0; i < c->list.n; ++i) {
        char who[48];
        snprintf(who, sizeof who, "body %u of %u", c->of ? c->of[i] : i, command_count(c));
        if (motion_lacks(missing_with(m, &all, c, i, 1), c->call, who, err)) {
            if (c->blamed)
                *c->blamed = c->of[i];
            break;
        }
    }
    return false;
}

bool command_add_facts(const duet_motion *m, const command *c, effect_facts *facts, duet_error *err)
{
    effect_facts all = *facts;
    if (!c->bodies)
        return true;
    if (missing_with(m, &all, c, 0, c->list.n))
        return name_who_lacks(m, c, *facts, err);
    *facts = all;
    return true;
}

bool command_admit(duet_motion *m, effect_facts facts, duet_error *err)
{
    const effect_facts before = m->facts;
    bool tumbles = (m->effects & DUET_EFFECT_ANGULAR_VELOCITY) && (facts & ~before & FACT_UNEVEN);
    m->facts = facts;
    if (!tumbles || motion_prepare_again(m, err))
        return true;
    m->facts = before;
    return false;
}
