// SPDX-License-Identifier: MIT
// Bodies that come and go.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/recording.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- coming

static bool open_arrivals(motion_placed *p, const duet_pose *poses, const duet_body *bodies,
                          uint32_t n, const char *call, duet_error *err)
{
    *p = (motion_placed){.n = n,
                         .places = malloc((size_t)n * sizeof *p->places + 1),
                         .poses = malloc((size_t)n * sizeof *poses + 1),
                         .bodies = malloc((size_t)n * sizeof *bodies + 1)};
    if (!p->poses || !p->bodies || !p->places)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u bodies", call, n);
    for (uint32_t i = 0; i < n; ++i) {
        p->poses[i] = poses[i];
        p->bodies[i] = bodies ? bodies[i] : duet_default_body();
    }
    return true;
}

// The lowest empty places, and then new ones at the end.
static bool choose_places(const duet_motion *m, motion_placed *p, uint32_t *n_places,
                          const char *call, duet_error *err)
{
    uint32_t place = m->commands->first_empty;
    for (uint32_t i = 0; i < p->n; ++i) {
        while (place < m->n && m->commands->states[place] != PLACE_EMPTY)
            ++place;
        if (place >= MOTION_MOST)
            return error_set(err, DUET_STATUS_TOO_MANY, "%s: a motion has at most %u places", call,
                             MOTION_MOST);
        p->places[i] = place++;
    }
    *n_places = place > m->n ? place : m->n;
    return true;
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
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bodies", most);
    c->capacity = most;
    return true;
}

// Walls are the objects after the last.
static bool move_walls(duet_motion *m, uint32_t old_n, duet_error *err)
{
    motion_rows rows;
    if (!m->kernels.contact_graph_walls || m->n_contacts == 0)
        return true;
    if (!motion_rows_of_contacts(m, LINKS, 2, &rows, err))
        return false;
    for (uint32_t i = 0; i < m->n_contacts; ++i) {
        uint32_t *link = motion_row(&rows, i);
        link[1] += link[1] >= old_n ? m->n - old_n : 0;
    }
    return motion_rows_close(m, &rows, err);
}

static bool make_space(duet_motion *m, uint32_t n, duet_error *err)
{
    uint32_t old_n = m->n;
    if (n == old_n)
        return true;
    if (!reserve_host(m, n, err))
        return false;
    motion_commands *c = m->commands;
    memset(c->generations + old_n, 0, (n - old_n) * sizeof *c->generations);
    memset(c->user_data + old_n, 0, (n - old_n) * sizeof *c->user_data);
    memset(c->states + old_n, PLACE_EMPTY, n - old_n);
    c->n_hidden += n - old_n;
    m->n = n;
    motion_forget_events(&m->told); // walls have other numbers
    return motion_keep_whole(m, motion_grow(m, old_n, err) && timeline_finish(&m->times, err) &&
                                    move_walls(m, old_n, err));
}

static bool settle(duet_motion *m, const motion_placed *p, uint64_t *ids, duet_error *err)
{
    motion_commands *c = m->commands;
    if (p->n == 0)
        return true;
    motion_alter_places(m, p->places, p->n);
    m->reading.n_told = 0;
    for (uint32_t i = 0; i < p->n; ++i) {
        uint32_t place = p->places[i];
        m->bodies[place] = p->bodies[i];
        --c->n_hidden;
        c->states[place] = PLACE_ENABLED;
        if (ids)
            ids[i] = (uint64_t)c->generations[place] << 32 | place;
    }
    motion_placed_keep(m, p);
    c->first_empty = p->places[p->n - 1] + 1;
    return motion_send_places(m, p->places, p->n, PART_ALL, err) &&
           motion_set_asleep(m, p->places, p->n, false, err);
}

bool duet_motion_add_bodies(duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                            uint32_t n, uint64_t *ids, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) ||
        (n > 0 && !error_given(poses, __func__, "poses", err)))
        return false;
    motion_placed p = {0};
    uint32_t n_places = 0;
    bool ok = timeline_finish(&m->times, err) && motion_begin_commands(m, err) &&
              open_arrivals(&p, poses, bodies, n, __func__, err) &&
              motion_placed_check(m, &p, PART_ALL, __func__, err) &&
              motion_placed_settle(m, &p, __func__, err) &&
              choose_places(m, &p, &n_places, __func__, err) &&
              motion_placed_admit(m, &p, __func__, err) && make_space(m, n_places, err) &&
              motion_keep_whole(m, settle(m, &p, ids, err));
    if (ok)
        motion_note_arrivals(m, poses, p.bodies, n);
    motion_placed_close(&p);
    return ok;
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
    c->any_left = true;
    ++c->generations[place];
    c->user_data[place] = 0;
    m->bodies[place] = (duet_body){.group = m->bodies[place].group, .mask = m->bodies[place].mask};
}

// One id twice in a list would be stale the second time.
static bool check_twice(const duet_motion *m, const uint32_t *places, uint32_t n, const char *call,
                        duet_error *err)
{
    uint8_t *seen = calloc((size_t)m->n + 1, 1);
    if (!seen)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u places", call, m->n);
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i) {
        if (seen[places[i]]++)
            ok = error_set(err, DUET_STATUS_BAD_ARGUMENT,
                           "%s: body %u of %u: the body at place %u is listed twice", call, i, n,
                           places[i]);
    }
    free(seen);
    return ok;
}

bool duet_motion_remove_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    PUBLIC_CALL(err);
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    bool ok = places && check_twice(m, places, list.n, __func__, err) &&
              motion_forget_targets(m, places, list.n, err);
    for (uint32_t i = 0; ok && i < list.n; ++i)
        leave(m, places[i]);
    ok = ok && motion_keep_whole(m, send_presence(m, places, list.n, err));
    if (ok)
        motion_note(m, RECORDED_REMOVE, places, list.n, NULL);
    free(places);
    return ok;
}

bool duet_motion_disable_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    PUBLIC_CALL(err);
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    bool ok = places && motion_forget_targets(m, places, list.n, err);
    for (uint32_t i = 0; ok && i < list.n; ++i) {
        if (motion_is_hidden(m, places[i]))
            continue;
        m->commands->states[places[i]] = PLACE_DISABLED;
        ++m->commands->n_hidden;
        motion_stop(m, places[i]);
    }
    ok = ok && motion_keep_whole(m, send_presence(m, places, list.n, err));
    if (ok)
        motion_note(m, RECORDED_DISABLE, places, list.n, NULL);
    free(places);
    return ok;
}

// Those that are enabled already keep what they do.
bool duet_motion_enable_bodies(duet_motion *m, duet_body_list list, duet_error *err)
{
    PUBLIC_CALL(err);
    uint32_t *places = motion_places_of(m, list, false, __func__, err);
    uint32_t n = 0;
    for (uint32_t i = 0; places && i < list.n; ++i) {
        if (!motion_is_hidden(m, places[i]))
            continue;
        m->commands->states[places[i]] = PLACE_ENABLED;
        --m->commands->n_hidden;
        places[n++] = places[i];
    }
    bool ok = places && motion_keep_whole(m, send_presence(m, places, n, err));
    if (ok)
        motion_note(m, RECORDED_ENABLE, places, n, NULL);
    free(places);
    return ok;
}
