// SPDX-License-Identifier: MIT
// Bodies that come and go.
#include "base/error.h"
#include "runtime/bodies/ground_def.h"
#include "runtime/commands/command.h"
#include "runtime/dynamics/motion_rows.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- coming

// The lowest empty places, and then new ones at the end.
static bool choose_places(const duet_motion *m, command *c, duet_error *err)
{
    uint32_t place = m->commands->first_empty;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        while (place < m->n && m->commands->states[place] != PLACE_EMPTY)
            ++place;
        if (place >= MOTION_MOST)
            return error_set(err, DUET_STATUS_TOO_MANY, "%s: a motion has at most %u places",
                             c->call, MOTION_MOST);
        c->places[i] = place++;
    }
    return true;
}

// Places ascend.
static uint32_t places_with(const duet_motion *m, const command *c)
{
    uint32_t end = c->list.n > 0 ? c->places[c->list.n - 1] + 1 : 0;
    return end > m->n ? end : m->n;
}

// at: a pointer to an array, of whatever type.
static bool widen(void *at, size_t each, uint32_t n)
{
    void *array;
    memcpy(&array, at, sizeof array);
    array = realloc(array, (size_t)n * each + each);
    if (array)
        memcpy(at, &array, sizeof array);
    return array;
}

static bool reserve_host(duet_motion *m, uint32_t n, duet_error *err)
{
    motion_commands *c = m->commands;
    if (n <= c->capacity)
        return true;
    uint64_t roomy = n + (uint64_t)n / 2;
    uint32_t most = (uint32_t)(roomy < MOTION_MOST ? roomy : MOTION_MOST);
    if (!widen(&m->poses, sizeof *m->poses, most) || !widen(&m->bodies, sizeof *m->bodies, most) ||
        (m->cells && !widen(&m->cells, sizeof *m->cells, most)) ||
        !widen(&c->generations, sizeof *c->generations, most) ||
        !widen(&c->states, sizeof *c->states, most) ||
        !widen(&c->user_data, sizeof *c->user_data, most))
        return no_memory(err, "%u bodies", most);
    c->capacity = most;
    return true;
}

// Walls and the ground are the objects after the last. A contact in another domain has no place at
// all.
static bool move_fixed(duet_motion *m, uint32_t old_n, duet_error *err)
{
    motion_rows rows;
    const bool touches = motion_touches_walls(m) || motion_touches_ground(m);
    if (!touches || m->graph.n_contacts == 0)
        return true;
    if (!motion_rows_of_words(m, LINKS, m->graph.n_contacts, 2, &rows, err))
        return false;
    for (uint32_t i = 0; i < m->graph.n_contacts; ++i) {
        uint32_t *link = motion_row(&rows, i);
        link[1] += link[0] < old_n && link[1] >= old_n ? m->n - old_n : 0;
    }
    return motion_rows_close(m, &rows, err);
}

static bool make_space(duet_motion *m, uint32_t n, duet_error *err)
{
    motion_commands *c = m->commands;
    uint32_t old_n = m->n;
    if (n == old_n)
        return true;
    memset(c->generations + old_n, 0, (n - old_n) * sizeof *c->generations);
    memset(c->user_data + old_n, 0, (n - old_n) * sizeof *c->user_data);
    memset(c->states + old_n, PLACE_EMPTY, n - old_n);
    c->n_hidden += n - old_n;
    m->n = n;
    motion_forget_events(&m->told); // walls and ground have other numbers
    return motion_grow(m, old_n, err) && timeline_finish(&m->times, err) &&
           move_fixed(m, old_n, err);
}

static bool settle(duet_motion *m, const command *c, duet_error *err)
{
    motion_commands *left = m->commands;
    if (c->list.n == 0)
        return true;
    motion_alter_places(m, c->places, c->list.n);
    m->reading.n_told = 0;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        uint32_t place = c->places[i];
        m->bodies[place] = c->bodies[i];
        --left->n_hidden;
        left->states[place] = PLACE_ENABLED;
        if (c->new_ids)
            c->new_ids[i] = motion_id_at(m, place);
    }
    command_keep_poses(m, c);
    left->first_empty = c->places[c->list.n - 1] + 1;
    return motion_send_places(m, c->places, c->list.n, PART_ALL, err) &&
           motion_set_asleep(m, c->places, c->list.n, false, err);
}

// A part of a command has places already.
bool check_add_bodies(duet_motion *m, command *c, duet_error *err)
{
    return command_copy(m, c, err) && command_check(m, c, PART_ALL, err) &&
           command_settle(m, c, err) && (c->of || choose_places(m, c, err)) &&
           reserve_host(m, places_with(m, c), err);
}

bool act_add_bodies(duet_motion *m, command *c, duet_error *err)
{
    return make_space(m, places_with(m, c), err) && settle(m, c, err);
}

// ---------------------------------------------------------------- going

static bool send_presence(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    if (n == 0)
        return true;
    motion_alter_places(m, places, n);
    m->reading.n_told = 0;
    return motion_send_places(m, places, n,
                              PART_SIZE | PART_VELOCITY | PART_ANGULAR_VELOCITY | PART_MASS, err) &&
           motion_set_asleep(m, places, n, false, err);
}

static void leave(duet_motion *m, uint32_t place)
{
    motion_commands *c = m->commands;
    c->n_hidden += c->states[place] == PLACE_ENABLED;
    c->states[place] = PLACE_LEFT;
    ++c->n_left;
    ++c->generations[place];
    c->user_data[place] = 0;
    m->bodies[place] = (duet_body){.group = m->bodies[place].group, .mask = m->bodies[place].mask};
}

// One id twice in a list would be stale the second time.
static bool check_twice(const duet_motion *m, const command *c, duet_error *err)
{
    uint8_t *seen = calloc((size_t)m->n + 1, 1);
    if (!seen)
        return no_memory(err, "%u places in %s", m->n, c->call);
    bool ok = true;
    for (uint32_t i = 0; ok && i < c->list.n; ++i) {
        if (seen[c->places[i]]++)
            ok = command_fail(c, i, DUET_STATUS_BAD_ARGUMENT, err,
                              "the body at place %u is listed twice",
                              c->list.ids ? (uint32_t)c->list.ids[i] : c->list.first + i);
    }
    free(seen);
    return ok;
}

static bool check_carrier(const duet_motion *m, const command *c, duet_error *err)
{
    uint32_t carrier = ground_def_carrier(&m->def);
    for (uint32_t i = 0; i < c->list.n; ++i)
        if (c->places[i] + 1 == carrier)
            return bad_argument(err, "%s: body %u of %u carries the mesh; expected others",
                                c->op->call, i, c->list.n);
    return true;
}

bool check_remove_bodies(duet_motion *m, command *c, duet_error *err)
{
    return check_twice(m, c, err) && check_carrier(m, c, err);
}

bool act_remove_bodies(duet_motion *m, command *c, duet_error *err)
{
    const uint32_t n = c->list.n;
    if (!motion_forget_targets(m, c->places, n, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        leave(m, c->places[i]);
    return send_presence(m, c->places, n, err);
}

CHECKS_ITS_LIST(disable_bodies)
CHECKS_ITS_LIST(enable_bodies)

bool act_disable_bodies(duet_motion *m, command *c, duet_error *err)
{
    const uint32_t n = c->list.n;
    if (!motion_forget_targets(m, c->places, n, err))
        return false;
    for (uint32_t i = 0; i < n; ++i) {
        if (motion_is_hidden(m, c->places[i]))
            continue;
        m->commands->states[c->places[i]] = PLACE_DISABLED;
        ++m->commands->n_hidden;
        motion_stop(m, c->places[i]);
    }
    return send_presence(m, c->places, n, err);
}

// Bodies that are enabled already keep what they do.
bool act_enable_bodies(duet_motion *m, command *c, duet_error *err)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < c->list.n; ++i) {
        if (!motion_is_hidden(m, c->places[i]))
            continue;
        m->commands->states[c->places[i]] = PLACE_ENABLED;
        --m->commands->n_hidden;
        c->places[n++] = c->places[i];
    }
    return send_presence(m, c->places, n, err);
}

// ---------------------------------------------------------------- sleep

CHECKS_ITS_LIST(wake_bodies)
CHECKS_ITS_LIST(sleep_bodies)

bool act_wake_bodies(duet_motion *m, command *c, duet_error *err)
{
    return motion_set_asleep(m, c->places, c->list.n, false, err);
}

// A body without mass moves on, as it never sleeps. The places with mass come first then.
static bool stop_all(duet_motion *m, uint32_t *places, uint32_t n, duet_error *err)
{
    uint32_t n_stopped = 0;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t place = places[i];
        if (!(m->bodies[place].mass > 0.0f))
            continue;
        motion_stop(m, place);
        places[i] = places[n_stopped];
        places[n_stopped++] = place;
    }
    return motion_send_places(m, places, n_stopped, PART_VELOCITY | PART_ANGULAR_VELOCITY, err);
}

// A body that is sent to sleep stands still from then on: what it would have met is not met.
bool act_sleep_bodies(duet_motion *m, command *c, duet_error *err)
{
    return stop_all(m, c->places, c->list.n, err) &&
           motion_set_asleep(m, c->places, c->list.n, true, err);
}
