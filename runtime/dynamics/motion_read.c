// SPDX-License-Identifier: MIT
// What a caller reads: contacts, and states of all bodies, of given ids or of those that moved. The
// device gathers some, so that no others travel; what it needs is built and reserved when it is
// first asked for.
#include "runtime/dynamics/motion.h"

#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- rows

// One part of a state, and where it lies there.
static const struct {
    motion_buffer which;
    size_t at;
    size_t numbers;
} parts[] = {
    {CENTRES, offsetof(duet_state, centre), 3},
    {ROTATIONS, offsetof(duet_state, rotation), 4},
    {VELOCITIES, offsetof(duet_state, velocity), 3},
    {ANGULAR_VELOCITIES, offsetof(duet_state, angular_velocity), 3},
};

enum { PARTS = sizeof parts / sizeof parts[0], MOST_WORDS = 8 };

// Bodies whose states are read: those of n ids, or without ids n from the first on.
typedef struct reading {
    const uint32_t *ids;
    uint32_t first, n;
    uint32_t *space; // [n] rows, if B does not work on the host's memory
} reading;

static uint32_t place_of(const reading *r, uint32_t i)
{
    return r->ids ? r->ids[i] : r->first + i;
}

static bool begin(duet_motion *m, const reading *r, duet_error *err)
{
    return timeline_finish(&m->times, err) &&
           (!r->ids || (motion_reserve(m, READ_IDS, r->n, sizeof *r->ids, err) &&
                        motion_reserve(m, GATHERED, r->n, MOST_WORDS * sizeof *r->space, err) &&
                        timeline_write_at(&m->times, "send", &m->buffers[READ_IDS], 0, r->ids,
                                          r->n * sizeof *r->ids, err)));
}

static bool gather(duet_motion *m, motion_buffer which, uint32_t words, uint32_t n, duet_error *err)
{
    m->reading.rows = m->buffers[which];
    m->reading.row_words = words;
    m->reading.n_ids = n;
    return motion_launch(m, GATHER_ROWS, err);
}

// The rows of a buffer, of so many words each; NULL after a failure.
static const uint32_t *fetch(duet_motion *m, const reading *r, motion_buffer which, uint32_t words,
                             duet_error *err)
{
    const size_t row = words * sizeof(uint32_t), at = r->first * row, bytes = r->n * row;
    buffer *b = &m->buffers[r->ids ? GATHERED : which];
    if (r->ids && !gather(m, which, words, r->n, err))
        return NULL;
    if (b->host)
        return timeline_read(&m->times, "fetch", b, b->host, at + bytes, err)
                   ? (const uint32_t *)((const char *)b->host + at)
                   : NULL;
    return timeline_read_at(&m->times, "fetch", b, at, r->space, bytes, err) ? r->space : NULL;
}

// The first n numbers of a row.
static void read_numbers(const uint32_t *row, bool doubles, size_t n, double *numbers)
{
    float number;
    for (size_t k = 0; k < n && !doubles; ++k) {
        memcpy(&number, row + k, sizeof number);
        numbers[k] = (double)number;
    }
    if (doubles)
        memcpy(numbers, row, n * sizeof *numbers);
}

// A motion that lacks a part has no words of it.
static bool fetch_part(duet_motion *m, const reading *r, size_t p, duet_state *states,
                       duet_error *err)
{
    const uint32_t words = motion_words(m, parts[p].which);
    const size_t n = parts[p].numbers, at = parts[p].at;
    const uint32_t *rows = words > 0 ? fetch(m, r, parts[p].which, words, err) : NULL;
    for (uint32_t i = 0; rows && i < r->n; ++i)
        read_numbers(rows + (size_t)i * words, m->def.doubles, n,
                     (double *)((char *)&states[i] + at));
    return rows || words == 0;
}

// Centres were read as offsets in their cells: these are for the caller, or are added.
static bool fetch_cells(duet_motion *m, const reading *r, duet_state *states, cl_int4 *cells,
                        duet_error *err)
{
    const uint32_t *rows = fetch(m, r, CELLS, 4, err);
    if (rows && cells)
        memcpy(cells, rows, r->n * sizeof *cells);
    for (uint32_t i = 0; rows && !cells && i < r->n; ++i)
        for (uint32_t k = 0; k < m->def.dims; ++k)
            states[i].centre[k] += (double)(int32_t)rows[4 * (size_t)i + k] * m->def.origin_edge;
    return rows;
}

// ---------------------------------------------------------------- states

// Numbers that are no longer finite are told here at the latest.
static bool check_finite(const duet_motion *m, const reading *r, const duet_state *states,
                         duet_error *err)
{
    for (uint32_t i = 0; i < r->n; ++i)
        for (size_t k = 0; k < sizeof *states / sizeof(double); ++k)
            if (!isfinite(((const double *)&states[i])[k]))
                return error_set(err, DUET_STATUS_BAD_OBJECT,
                                 "object %u of %u: its state after step %llu is not finite",
                                 place_of(r, i), m->n, (unsigned long long)m->step);
    return true;
}

static bool fetch_states(duet_motion *m, reading *r, duet_state *states, cl_int4 *cells,
                         duet_error *err)
{
    if (r->n == 0)
        return true;
    r->space = malloc((size_t)r->n * MOST_WORDS * sizeof *r->space);
    if (!r->space)
        return no_memory(err, "%u states", r->n);
    bool given = motion_words(m, ROTATIONS) == 0 || motion_words(m, ANGULAR_VELOCITIES) == 0;
    for (uint32_t i = 0; given && i < r->n; ++i)
        motion_given_state(m, place_of(r, i), &states[i]);
    bool ok = begin(m, r, err);
    for (size_t p = 0; ok && p < PARTS; ++p)
        ok = fetch_part(m, r, p, states, err);
    ok = ok && (!m->cells || fetch_cells(m, r, states, cells, err)) &&
         timeline_finish(&m->times, err);
    free(r->space);
    return ok && check_finite(m, r, states, err);
}

bool motion_fetch_states(duet_motion *m, const uint32_t *ids, uint32_t n, duet_state *states,
                         cl_int4 *cells, duet_error *err)
{
    reading r = {.ids = ids, .n = n};
    return fetch_states(m, &r, states, cells, err);
}

// States that are read at once for a sum: few for a cache, many for a transfer.
enum { SUMMED_AT_ONCE = 16384 };

bool motion_sum_states(duet_motion *m, add_state add, void *sum, duet_error *err)
{
    duet_state *states = malloc(SUMMED_AT_ONCE * sizeof *states);
    bool ok = states || no_memory(err, "%u states", m->n);
    for (reading r = {.n = 0}; ok && r.first < m->n; r.first += r.n) {
        r.n = m->n - r.first < SUMMED_AT_ONCE ? m->n - r.first : SUMMED_AT_ONCE;
        ok = fetch_states(m, &r, states, NULL, err);
        for (uint32_t i = 0; ok && i < r.n; ++i)
            add(m, r.first + i, &states[i], sum);
    }
    free(states);
    return ok;
}

bool duet_motion_get_states(duet_motion *m, duet_state *states, duet_error *err)
{
    PUBLIC_CALL(err);
    return motion_is_whole(m, __func__, err) &&
           (m->n == 0 || error_given(states, __func__, "states", err)) &&
           motion_fetch_states(m, NULL, m->n, states, NULL, err);
}

duet_state *motion_read_states(duet_motion *m, duet_error *err)
{
    duet_state *states = malloc(((size_t)m->n + 1) * sizeof *states);
    if (!states)
        return null_no_memory(err, "%u states", m->n);
    if (motion_fetch_states(m, NULL, m->n, states, NULL, err))
        return states;
    free(states);
    return NULL;
}

bool duet_motion_get_states_of(duet_motion *m, const uint32_t *places, uint32_t n,
                               duet_state *states, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) ||
        (n > 0 && (!error_given(places, __func__, "places", err) ||
                   !error_given(states, __func__, "states", err))))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        if (places[i] >= m->n)
            return bad_argument(err, "place %u, in row %u; expected one below %u", places[i], i,
                                m->n);
    return motion_fetch_states(m, places, n, states, NULL, err);
}

// ---------------------------------------------------------------- sleep

// A body that is disabled or gone keeps the word that its last step wrote.
static bool read_asleep(duet_motion *m, uint32_t *words, uint8_t *asleep, duet_error *err)
{
    bool ok =
        !(m->effects & DUET_EFFECT_SLEEP) || m->n == 0 ||
        (timeline_read(&m->times, "fetch", &m->buffers[ASLEEP], words, m->n * sizeof *words, err) &&
         timeline_finish(&m->times, err));
    for (uint32_t place = 0; ok && place < m->n; ++place)
        asleep[place] = (words[place] & SLEEPS) && !motion_is_hidden(m, place);
    return ok;
}

bool duet_motion_get_asleep(duet_motion *m, uint8_t *asleep, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) ||
        (m->n > 0 && !error_given(asleep, __func__, "asleep", err)))
        return false;
    uint32_t *words = calloc((size_t)m->n + 1, sizeof *words);
    if (!words)
        return no_memory(err, "%u states", m->n);
    bool ok = read_asleep(m, words, asleep, err);
    free(words);
    return ok;
}

// ---------------------------------------------------------------- what moved

static const struct {
    motion_buffer which, last;
} places[] = {{CENTRES, LAST_CENTRES}, {CELLS, LAST_CELLS}, {ROTATIONS, LAST_ROTATIONS}};

enum { PLACES = sizeof places / sizeof places[0] };

static bool find_changed(duet_motion *m, uint32_t *words, duet_error *err)
{
    size_t n_words = ((size_t)m->n + 31) / 32;
    bool ok = motion_reserve(m, CHANGED, n_words, sizeof *words, err) &&
              motion_clear(m, "moved", CHANGED, 0, n_words, err);
    for (int i = 0; ok && i < PLACES; ++i) {
        uint32_t row_words = motion_words(m, places[i].which);
        if (row_words == 0)
            continue;
        ok = motion_reserve(m, places[i].last, m->n, row_words * sizeof *words, err);
        m->reading.rows = m->buffers[places[i].which];
        m->reading.last_rows = m->buffers[places[i].last];
        m->reading.row_words = row_words;
        ok = ok && motion_launch(m, CHANGED_ROWS, err);
    }
    return ok && timeline_read(&m->times, "moved", &m->buffers[CHANGED], words,
                               n_words * sizeof *words, err);
}

void motion_forget_moved(motion_reading *r)
{
    free(r->ids);
    free(r->states);
    r->ids = NULL;
    r->states = NULL;
    r->n_told = 0;
}

// All bodies are told again if there are more or fewer than before.
static bool reserve_reading(duet_motion *m, duet_error *err)
{
    motion_reading *r = &m->reading;
    if (r->ids && r->states && r->n == m->n)
        return true;
    motion_forget_moved(r);
    r->n = m->n;
    r->ids = malloc(((size_t)m->n + 1) * sizeof *r->ids);
    r->states = malloc(((size_t)m->n + 1) * sizeof *r->states);
    return (r->ids && r->states) || no_memory(err, "%u states", m->n);
}

// Bodies that were never read have moved.
static uint32_t list_moved(duet_motion *m, const uint32_t *words)
{
    uint32_t n = 0;
    for (uint32_t id = 0; id < m->n; ++id)
        if (id >= m->reading.n_told || (words[id / 32] >> id % 32 & 1u))
            m->reading.ids[n++] = id;
    return n;
}

// After a failure all is told again.
static bool read_moved(duet_motion *m, uint32_t *words, duet_moved *moved, duet_error *err)
{
    motion_reading *r = &m->reading;
    bool ok = m->n == 0 || find_changed(m, words, err);
    uint32_t n = ok ? list_moved(m, words) : 0;
    ok = ok && motion_fetch_states(m, r->ids, n, r->states, NULL, err);
    r->n_told = ok ? m->n : 0;
    *moved = (duet_moved){.places = r->ids, .states = r->states, .n = n};
    return ok;
}

bool duet_motion_get_moved(duet_motion *m, duet_moved *moved, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !error_given(moved, __func__, "moved", err))
        return false;
    uint32_t *words = calloc((size_t)m->n / 32 + 1, sizeof *words);
    if (!words)
        return no_memory(err, "%u states", m->n);
    bool ok = timeline_finish(&m->times, err) && reserve_reading(m, err) &&
              read_moved(m, words, moved, err);
    free(words);
    return ok;
}

// ---------------------------------------------------------------- contacts

static duet_contact read_record(const duet_motion *m, const uint32_t link[2], uint32_t n,
                                const float *record)
{
    const motion_layout *l = &m->layout;
    duet_contact c = {.a = link[0], .b = link[1], .n = n};
    if (c.b > m->n + AT_GROUND)
        c.b = m->n + AT_GROUND;
    memcpy(c.normal, record + AT_NORMAL, sizeof c.normal);
    for (uint32_t k = 0; k < n; ++k) {
        const float *saved = record + l->head + k * l->point;
        memcpy(c.points[k].anchor, saved + OF_ANCHOR, sizeof c.points[k].anchor);
        c.points[k].separation = saved[OF_SEPARATION];
        c.points[k].normal_impulse =
            (m->effects & DUET_EFFECT_CONTACT_RESPONSE) ? saved[OF_NORMAL_IMPULSE] : 0.0f;
    }
    return c;
}

bool motion_read_contacts(duet_motion *m, duet_contact **contacts, uint64_t *n, duet_error *err)
{
    size_t count = m->graph.n_contacts;
    size_t record = m->layout.record;
    uint32_t(*links)[2] = malloc(count * sizeof *links + 1);
    uint32_t *touches = malloc(count * sizeof *touches + 1);
    float *records = malloc(count * record * sizeof *records + 1);
    duet_contact *found = malloc(count * sizeof *found + 1);
    bool ok = links && touches && records && found;
    if (!ok)
        no_memory(err, "%zu contacts", count);
    ok = ok &&
         timeline_read(&m->times, "fetch", &m->buffers[LINKS], links, count * sizeof *links, err) &&
         timeline_read(&m->times, "fetch", &m->buffers[TOUCHES], touches, count * sizeof *touches,
                       err) &&
         timeline_read(&m->times, "fetch", &m->buffers[CONTACTS], records,
                       count * record * sizeof *records, err);
    *n = 0;
    for (size_t i = 0; ok && i < count; ++i)
        if (touches[i] & TOUCH_POINTS)
            found[(*n)++] =
                read_record(m, links[i], touches[i] & TOUCH_POINTS, records + i * record);
    free(links);
    free(touches);
    free(records);
    *contacts = ok ? found : NULL;
    if (!ok)
        free(found);
    return ok;
}

bool duet_motion_get_contacts(duet_motion *m, duet_contact **contacts, uint64_t *n, duet_error *err)
{
    PUBLIC_CALL(err);
    return motion_is_whole(m, __func__, err) && error_given(contacts, __func__, "contacts", err) &&
           error_given(n, __func__, "n", err) && motion_read_contacts(m, contacts, n, err) &&
           timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- between two states

static void mix(const double *from, const double *to, double fraction, double *out, int n)
{
    for (int k = 0; k < n; ++k)
        out[k] = (1.0 - fraction) * from[k] + fraction * to[k];
}

// The way a rotation goes from step to step is short, so that a straight line between the
// quaternions, brought back to length 1, is it within a third of a degree for 45 degrees.
duet_state duet_state_between(const duet_state *from, const duet_state *to, double fraction)
{
    duet_state out = {.rotation = {0, 0, 0, 1}};
    if (!from || !to)
        return out;
    double along = 0, nearer[4];
    for (int k = 0; k < 4; ++k)
        along += from->rotation[k] * to->rotation[k];
    for (int k = 0; k < 4; ++k)
        nearer[k] = along < 0 ? -to->rotation[k] : to->rotation[k];
    mix(from->centre, to->centre, fraction, out.centre, 3);
    mix(from->velocity, to->velocity, fraction, out.velocity, 3);
    mix(from->angular_velocity, to->angular_velocity, fraction, out.angular_velocity, 3);
    mix(from->rotation, nearer, fraction, out.rotation, 4);
    double length = 0;
    for (int k = 0; k < 4; ++k)
        length += out.rotation[k] * out.rotation[k];
    length = sqrt(length);
    for (int k = 0; k < 4; ++k)
        out.rotation[k] = length > 0 ? out.rotation[k] / length : from->rotation[k];
    return out;
}
