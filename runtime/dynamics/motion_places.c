// SPDX-License-Identifier: MIT
// Places and ids, and what a step leaves of commands.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/recording.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- owner

static void *copy_of(const void *from, size_t bytes)
{
    void *to = malloc(bytes + 1);
    if (to && from)
        memcpy(to, from, bytes);
    return to;
}

static bool fill_commands(motion_commands *c, const duet_motion *m)
{
    size_t n = m->n;
    c->given = (motion_given){
        .n = m->n,
        .def = m->def,
        .poses = copy_of(m->poses, n * sizeof *m->poses),
        .cells = m->cells ? copy_of(m->cells, n * sizeof *m->cells) : NULL,
        .bodies = copy_of(m->bodies, n * sizeof *m->bodies),
    };
    c->capacity = m->n;
    c->generations = calloc(n + 1, sizeof *c->generations);
    c->states = malloc(n + 1);
    c->user_data = calloc(n + 1, sizeof *c->user_data);
    c->first_empty = m->n;
    if (c->states)
        memset(c->states, PLACE_ENABLED, n);
    return c->given.poses && (c->given.cells || !m->cells) && c->given.bodies && c->generations &&
           c->states && c->user_data;
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
    free(c->given.poses);
    free(c->given.cells);
    free(c->given.bodies);
    free(c->generations);
    free(c->states);
    free(c->user_data);
    free(c->targets);
    free(c->altered);
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

// ---------------------------------------------------------------- user data

bool duet_motion_set_user_data(duet_motion *m, duet_body_list list, const uint64_t *data,
                               duet_error *err)
{
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
    if (list.n > 0 && !error_given(data, __func__, "data", err))
        return false;
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    for (uint32_t i = 0; places && i < list.n; ++i)
        data[i] = m->commands->user_data[places[i]];
    free(places);
    return places;
}

// ---------------------------------------------------------------- sleep

// What has no mass never sleeps; that it changed is told to those that touch it.
static bool mark_rests(duet_motion *m, const uint32_t *places, uint32_t n, bool sleeps,
                       duet_error *err)
{
    motion_rows rows;
    const double rested = fmax(m->def.sleep_after, m->def.dt);
    if (!motion_rows_at(m, RESTS, places, n, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i) {
        bool hidden = motion_is_hidden(m, places[i]);
        if (hidden || m->bodies[places[i]].mass > 0.0f)
            motion_row_set(&rows, places[i], 0, sleeps && !hidden ? rested : 0.0);
        else if (!sleeps)
            motion_row_set(&rows, places[i], 0, -1.0);
    }
    return motion_rows_close(m, &rows, err);
}

// What is sent to sleep is awake for the step that finds it at rest: its contacts are then
// those of where it lies.
static bool mark_awake(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_rows rows;
    if (!motion_rows_at(m, ASLEEP, places, n, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        *(uint32_t *)motion_row(&rows, places[i]) = 0;
    return motion_rows_close(m, &rows, err);
}

static bool mark(duet_motion *m, const uint32_t *places, uint32_t n, bool sleeps, duet_error *err)
{
    if (n == 0)
        return true;
    m->at_rest = false;
    return !motion_has(m, DUET_EFFECT_SLEEP) ||
           (mark_rests(m, places, n, sleeps, err) && mark_awake(m, places, n, err));
}

bool motion_wake_still(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    return mark(m, places, n, false, err);
}

bool motion_wake_places(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    m->bounds_checked = m->bounds_checked && n == 0;
    return motion_wake_still(m, places, n, err);
}

bool motion_wake_all(duet_motion *m, duet_error *err)
{
    m->at_rest = m->bounds_checked = false;
    return !motion_has(m, DUET_EFFECT_SLEEP) ||
           (timeline_fill(&m->times, "clear", &m->buffers[RESTS], 0, 0, m->n, err) &&
            timeline_fill(&m->times, "clear", &m->buffers[ASLEEP], 0, 0, m->n, err) &&
            timeline_finish(&m->times, err));
}

static bool put_to(duet_motion *m, duet_body_list list, bool sleeps, const char *call,
                   duet_error *err)
{
    uint32_t *places = motion_places_of(m, list, true, call, err);
    bool ok = places && motion_needs(m, DUET_EFFECT_SLEEP, call, err) &&
              motion_keep_whole(m, mark(m, places, list.n, sleeps, err));
    if (ok)
        motion_note(m, sleeps ? RECORDED_SLEEP : RECORDED_WAKE, places, list.n, NULL);
    free(places);
    return ok;
}

bool duet_motion_wake_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    return put_to(m, list, false, __func__, err);
}

bool duet_motion_sleep_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    return put_to(m, list, true, __func__, err);
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
    if (c->any_left && (!motion_rows_are_stale(m) || !motion_has(m, DUET_EFFECT_CONTACT)))
        empty_places(m);
    return (c->n_targets == 0 || motion_arrive(m, err)) && (!c->pushed || forget_forces(m, err));
}
