// SPDX-License-Identifier: MIT
// Places and ids, and what a step leaves of commands.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/recording.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- owner

static bool fill_commands(motion_commands *c, const duet_motion *m)
{
    size_t n = m->n;
    c->capacity = m->n;
    c->generations = calloc(n + 1, sizeof *c->generations);
    c->states = malloc(n + 1);
    c->user_data = calloc(n + 1, sizeof *c->user_data);
    c->first_empty = m->n;
    if (c->states)
        memset(c->states, PLACE_ENABLED, n);
    return c->generations && c->states && c->user_data;
}

bool motion_begin_commands(duet_motion *m, duet_error *err)
{
    if (m->commands)
        return true;
    m->commands = calloc(1, sizeof *m->commands);
    if (m->commands && fill_commands(m->commands, m))
        return true;
    motion_forget_commands(m->commands);
    m->commands = NULL;
    return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for commands to %u objects", m->n);
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

// ---------------------------------------------------------------- ids

static uint64_t id_at(const duet_motion *m, uint32_t place)
{
    return m->commands ? (uint64_t)m->commands->generations[place] << 32 | place : place;
}

static bool is_there(const duet_motion *m, uint32_t place)
{
    return !m->commands || m->commands->states[place] >= PLACE_DISABLED;
}

bool duet_motion_has_body(const duet_motion *m, uint64_t id)
{
    uint32_t place = (uint32_t)id;
    return m && place < m->n && id_at(m, place) == id && is_there(m, place);
}

// Whether number i of a list is a body that the call can use.
static bool check_place(const duet_motion *m, const duet_body_list *list, uint32_t i, bool enabled,
                        const char *call, duet_error *err)
{
    uint64_t id = list->ids ? list->ids[i] : list->first + (uint64_t)i;
    uint32_t place = (uint32_t)id;
    if (id == DUET_NO_BODY || (list->ids ? place : id) >= m->n)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: body %u of %u: there is no body %llu; the motion has %u places", call,
                         i, list->n, (unsigned long long)id, m->n);
    if (!is_there(m, place) || (list->ids && id_at(m, place) != id))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: body %u of %u: the body with id %llu was removed", call, i, list->n,
                         (unsigned long long)(list->ids ? id : id_at(m, place)));
    return !enabled || !motion_is_hidden(m, place) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%s: body %u of %u: the body with id %llu is disabled", call, i, list->n,
                     (unsigned long long)id_at(m, place));
}

uint32_t *motion_places_of(duet_motion *m, duet_body_list list, bool enabled, const char *call,
                           duet_error *err)
{
    if (!motion_is_whole(m, call, err))
        return NULL;
    uint32_t *places = malloc((size_t)list.n * sizeof *places + 1);
    if (!places) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u places", call, list.n);
        return NULL;
    }
    bool ok = timeline_finish(&m->times, err);
    for (uint32_t i = 0; ok && i < list.n; ++i) {
        ok = check_place(m, &list, i, enabled, call, err);
        places[i] = (uint32_t)(list.ids ? list.ids[i] : list.first + (uint64_t)i);
    }
    if (ok && motion_begin_commands(m, err))
        return places;
    free(places);
    return NULL;
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
        ids[i] = is_there(m, first + i) ? id_at(m, first + i) : DUET_NO_BODY;
    return true;
}

// ---------------------------------------------------------------- copies

bool motion_placed_open(motion_placed *p, duet_motion *m, duet_body_list list, bool enabled,
                        const char *call, duet_error *err)
{
    size_t n = list.n;
    *p = (motion_placed){.n = list.n, .places = motion_places_of(m, list, enabled, call, err)};
    if (!p->places)
        return false;
    p->poses = malloc(n * sizeof *p->poses + 1);
    p->bodies = malloc(n * sizeof *p->bodies + 1);
    if (!p->poses || !p->bodies)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u bodies", call, list.n);
    for (uint32_t i = 0; i < list.n; ++i) {
        p->poses[i] = m->poses[p->places[i]];
        p->bodies[i] = m->bodies[p->places[i]];
    }
    return true;
}

void motion_placed_close(motion_placed *p)
{
    free(p->cells);
    free(p->bodies);
    free(p->poses);
    free(p->places);
}

bool motion_placed_check(const duet_motion *m, const motion_placed *p, uint32_t parts,
                         const char *call, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n; ++i) {
        const char *fault = NULL;
        if (parts & PART_POSE)
            fault = motion_pose_fault(&p->poses[i], m->def.dims);
        if (!fault && (parts & ~(uint32_t)PART_POSE))
            fault = motion_body_fault(&p->bodies[i]);
        ok = !fault ||
             error_set(err, DUET_STATUS_BAD_OBJECT, "%s: body %u of %u: %s", call, i, p->n, fault);
    }
    return ok;
}

// ---------------------------------------------------------------- user data

bool duet_motion_set_user_data(duet_motion *m, duet_body_list list, const uint64_t *data,
                               duet_error *err)
{
    PUBLIC_CALL(err);
    if (list.n > 0 && !error_given(data, __func__, "data", err))
        return false;
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    for (uint32_t i = 0; places && i < list.n; ++i)
        m->commands->user_data[places[i]] = data[i];
    if (places)
        motion_note(m, RECORDED_USER_DATA, places, list.n, data);
    free(places);
    return places;
}

bool duet_motion_get_user_data(duet_motion *m, duet_body_list list, uint64_t *data, duet_error *err)
{
    PUBLIC_CALL(err);
    if (list.n > 0 && !error_given(data, __func__, "data", err))
        return false;
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    for (uint32_t i = 0; places && i < list.n; ++i)
        data[i] = m->commands->user_data[places[i]];
    free(places);
    return places;
}

// ---------------------------------------------------------------- after a step

static bool forget_forces(duet_motion *m, duet_error *err)
{
    m->commands->pushed = false;
    return timeline_fill(&m->times, "clear", &m->buffers[FORCES], 0, 0, (size_t)m->n * 8, err);
}

// A place whose ids are used up is never empty again.
static void empty_places(duet_motion *m)
{
    motion_commands *c = m->commands;
    c->any_left = false;
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
    if (c->any_left && (!motion_rows_are_stale(m) || !(m->effects & DUET_EFFECT_CONTACT)))
        empty_places(m);
    return !c->pushed || forget_forces(m, err);
}
