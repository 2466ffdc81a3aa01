// SPDX-License-Identifier: MIT
// The state of a motion: onto B, back, and sums over it.
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/rounded_inertia.h"
#include "runtime/dynamics/vector.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// By object, what each buffer holds: reals and 32-bit words; and the effects of
// which one must be called for, 0 for always.
static const struct {
    uint32_t effects;
    uint32_t reals;
    uint32_t words;
} by_object[MOTION_BUFFERS] = {
    [CENTRES] = {0, 4, 0},
    [VELOCITIES] = {0, 4, 0},
    [ROTATIONS] = {DUET_EFFECT_ROTATION, 4, 0},
    [ANGULAR_VELOCITIES] = {DUET_EFFECT_ANGULAR_VELOCITY, 4, 0},
    [INERTIAS] = {DUET_EFFECT_ANGULAR_VELOCITY, 0, 4},
    [HALVES] = {DUET_EFFECT_CONTACT | DUET_EFFECT_BOUNDARY, 0, 4},
    [RESTITUTIONS] = {DUET_EFFECT_CONTACT_RESPONSE, 0, 1},
    [FRICTIONS] = {DUET_EFFECT_FRICTION, 0, 1},
    [FILTERS] = {DUET_EFFECT_FILTER, 0, 2},
    [SENSORS] = {DUET_EFFECT_SENSORS, 0, 1},
    [RESTS] = {DUET_EFFECT_SLEEP, 0, 1},
    [ASLEEP] = {DUET_EFFECT_SLEEP, 0, 1},
    [FORCES] = {DUET_EFFECT_FORCES, 0, 8},
    [BOXES] = {DUET_EFFECT_CONTACT, 0, 6},
    [STARTS] = {DUET_EFFECT_CONTACT, 0, 1},
    [RETURN_STARTS] = {DUET_EFFECT_CONTACT, 0, 1},
    [USED] = {DUET_EFFECT_CONTACT_RESPONSE, 0, 1},
    [CHOICES] = {DUET_EFFECT_CONTACT_RESPONSE, 0, 1},
};

uint32_t motion_words(const duet_motion *m, motion_buffer which)
{
    if (which == CELLS)
        return m->cells ? 4 : 0;
    if (which == BODIES)
        return motion_has(m, DUET_EFFECT_CONTACT_RESPONSE) ? 4 * m->layout.body : 0;
    if (by_object[which].effects && !motion_has(m, by_object[which].effects))
        return 0;
    return by_object[which].reals * (m->def.doubles ? 2 : 1) + by_object[which].words;
}

// ---------------------------------------------------------------- onto B

// What one object has in a buffer, as doubles.
typedef struct entry {
    double at[4];
} entry;

static entry centre_of(const duet_motion *m, uint32_t id)
{
    const float *c = m->poses[id].centre;
    const double nowhere[3] = {0};
    const double *o = m->cells ? nowhere : m->def.origin;
    return (entry){{o[0] + c[0], o[1] + c[1], m->def.dims == 3 ? o[2] + c[2] : 0.0}};
}

static entry velocity_of(const duet_motion *m, uint32_t id)
{
    const duet_body *b = &m->bodies[id];
    double z = m->def.dims == 3 ? b->velocity[2] : 0.0;
    if (motion_is_hidden(m, id))
        return (entry){{0}};
    return (entry){{b->velocity[0], b->velocity[1], z, b->mass > 0.0f ? 1.0 / b->mass : 0.0}};
}

static entry rotation_of(const duet_motion *m, uint32_t id)
{
    const float *q = m->poses[id].rotation;
    double x = m->def.dims == 3 ? q[0] : 0.0;
    double y = m->def.dims == 3 ? q[1] : 0.0;
    double norm = sqrt(x * x + y * y + (double)q[2] * q[2] + (double)q[3] * q[3]);
    return (entry){{x / norm, y / norm, q[2] / norm, q[3] / norm}};
}

static entry angular_velocity_of(const duet_motion *m, uint32_t id)
{
    const float *w = m->bodies[id].angular_velocity;
    bool solid = m->def.dims == 3;
    if (motion_is_hidden(m, id))
        return (entry){{0}};
    return (entry){{solid ? w[0] : 0.0, solid ? w[1] : 0.0, w[2]}};
}

static double inverse_of(double inertia)
{
    return inertia > 0.0 ? 1.0 / inertia : 0.0;
}

// Of a solid body; one without extent across an axis is never turned about it.
static entry inertia_of(const duet_motion *m, uint32_t id)
{
    const float *h = m->poses[id].half_extents;
    const duet_body *b = &m->bodies[id];
    bool fixed = b->fixed_rotation || motion_is_hidden(m, id);
    if (b->radius > 0.0f) {
        double spread[3];
        rounded_spread(h, b->radius, m->def.dims, spread);
        double mass = fixed ? 0.0 : (double)b->mass;
        bool solid = m->def.dims == 3;
        return (entry){{solid ? inverse_of(mass * (spread[1] + spread[2])) : 0.0,
                        solid ? inverse_of(mass * (spread[0] + spread[2])) : 0.0,
                        inverse_of(mass * (spread[0] + spread[1]))}};
    }
    double third = fixed ? 0.0 : (double)b->mass / 3.0;
    double xx = (double)h[0] * h[0], yy = (double)h[1] * h[1], zz = (double)h[2] * h[2];
    if (m->def.dims == 2)
        return (entry){{0.0, 0.0, inverse_of(third * (xx + yy))}};
    return (entry){{inverse_of(third * (yy + zz)), inverse_of(third * (xx + zz)),
                    inverse_of(third * (xx + yy))}};
}

// Bounds of what is hidden end before they begin, and no search takes such ones.
static entry half_of(const duet_motion *m, uint32_t id)
{
    const double hidden = -1e18;
    if (motion_is_hidden(m, id))
        return (entry){{hidden, hidden, m->def.dims == 3 ? hidden : 0.0}};
    const float *h = m->poses[id].half_extents;
    return (entry){{h[0], h[1], m->def.dims == 3 ? h[2] : 0.0, m->bodies[id].radius}};
}

static entry restitution_of(const duet_motion *m, uint32_t id)
{
    return (entry){{m->bodies[id].restitution}};
}

static entry friction_of(const duet_motion *m, uint32_t id)
{
    return (entry){{m->bodies[id].friction}};
}

// 1: touches without pushing.
static entry sensor_of(const duet_motion *m, uint32_t id)
{
    return (entry){{m->bodies[id].sensor ? 1.0 : 0.0}};
}

// Sends n entries of `width` numbers, as doubles or floats.
static bool send(duet_motion *m, motion_buffer which, entry (*of)(const duet_motion *, uint32_t),
                 uint32_t width, bool doubles, duet_error *err)
{
    size_t size = doubles ? sizeof(double) : sizeof(float);
    size_t bytes = (size_t)m->n * width * size;
    char *host = malloc(bytes + 1);
    if (!host)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", bytes);
    for (uint32_t id = 0; id < m->n; ++id) {
        entry e = of(m, id);
        for (uint32_t k = 0; k < width; ++k) {
            size_t at = (size_t)id * width + k;
            if (doubles)
                ((double *)(void *)host)[at] = e.at[k];
            else
                ((float *)(void *)host)[at] = (float)e.at[k];
        }
    }
    bool ok = timeline_write(&m->times, "send", &m->buffers[which], host, bytes, err) &&
              timeline_finish(&m->times, err);
    free(host);
    return ok;
}

static bool send_filters(duet_motion *m, duet_error *err)
{
    uint32_t *host = malloc((size_t)m->n * 2 * sizeof *host + 1);
    if (!host)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for the groups of %u objects",
                         m->n);
    for (uint32_t id = 0; id < m->n; ++id) {
        host[2 * (size_t)id] = m->bodies[id].group;
        host[2 * (size_t)id + 1] = m->bodies[id].mask;
    }
    bool ok = timeline_write(&m->times, "send", &m->buffers[FILTERS], host,
                             (size_t)m->n * 2 * sizeof *host, err) &&
              timeline_finish(&m->times, err);
    free(host);
    return ok;
}

static bool reserve_all(duet_motion *m, duet_error *err)
{
    bool ok = !motion_has(m, DUET_EFFECT_CONTACT) ||
              motion_reserve(m, FLAG_WORDS, FLAGS, sizeof(uint32_t), err);
    for (int which = 0; ok && which < MOTION_BUFFERS; ++which) {
        uint32_t words = motion_words(m, (motion_buffer)which);
        if (words == 0)
            continue;
        uint64_t n = (uint64_t)m->n + MOTION_WALLS;
        ok = motion_reserve(m, (motion_buffer)which, n * words, sizeof(uint32_t), err) &&
             timeline_fill(&m->times, "clear", &m->buffers[which], 0, 0, (size_t)n * words, err);
    }
    return ok;
}

// What is sent, and the numbers of an entry that each part has.
static const struct {
    motion_buffer which;
    entry (*of)(const duet_motion *, uint32_t);
    uint32_t parts;
    uint32_t from, to;
} sent[] = {
    {CENTRES, centre_of, PART_POSE, 0, 4},
    {VELOCITIES, velocity_of, PART_VELOCITY, 0, 3},
    {VELOCITIES, velocity_of, PART_MASS, 3, 4},
    {ROTATIONS, rotation_of, PART_POSE, 0, 4},
    {ANGULAR_VELOCITIES, angular_velocity_of, PART_ANGULAR_VELOCITY, 0, 4},
    {INERTIAS, inertia_of, PART_MASS | PART_SIZE, 0, 4},
    {HALVES, half_of, PART_SIZE, 0, 4},
    {RESTITUTIONS, restitution_of, PART_SURFACE, 0, 1},
    {FRICTIONS, friction_of, PART_SURFACE, 0, 1},
    {SENSORS, sensor_of, PART_SENSOR, 0, 1},
};

bool motion_reset(duet_motion *m, duet_error *err)
{
    bool ok = reserve_all(m, err);
    for (size_t i = 0; ok && i < sizeof sent / sizeof sent[0]; ++i) {
        if (sent[i].from > 0)
            continue;
        motion_buffer which = sent[i].which;
        if (motion_words(m, which) == 0)
            continue;
        bool doubles = m->def.doubles && by_object[which].reals > 0;
        uint32_t width = by_object[which].reals + by_object[which].words;
        ok = send(m, which, sent[i].of, width, doubles, err);
    }
    ok = ok && (!motion_has(m, DUET_EFFECT_FILTER) || send_filters(m, err));
    if (ok && m->cells)
        ok = timeline_write(&m->times, "send", &m->buffers[CELLS], m->cells,
                            m->n * sizeof *m->cells, err);
    return ok && timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- some objects

static bool send_some_cells(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    uint32_t first, last;
    motion_rows rows;
    motion_span_of(places, n, &first, &last);
    if (!motion_rows_open(m, CELLS, first, last, 4, false, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        memcpy(motion_row(&rows, places[i]), &m->cells[places[i]], sizeof *m->cells);
    return motion_rows_close(m, &rows, err);
}

static bool send_some_filters(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    uint32_t first, last;
    motion_rows rows;
    motion_span_of(places, n, &first, &last);
    if (!motion_rows_open(m, FILTERS, first, last, 2, false, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i) {
        const duet_body *b = &m->bodies[places[i]];
        const uint32_t filter[2] = {b->group, b->mask};
        memcpy(motion_row(&rows, places[i]), filter, sizeof filter);
    }
    return motion_rows_close(m, &rows, err);
}

static bool send_some(duet_motion *m, const uint32_t *places, uint32_t n, size_t what,
                      duet_error *err)
{
    motion_buffer which = sent[what].which;
    uint32_t first, last;
    motion_rows rows;
    motion_span_of(places, n, &first, &last);
    if (!motion_rows_open(m, which, first, last, by_object[which].reals + by_object[which].words,
                          by_object[which].reals > 0, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i) {
        entry e = sent[what].of(m, places[i]);
        for (uint32_t k = sent[what].from; k < sent[what].to; ++k)
            motion_row_set(&rows, places[i], k, e.at[k]);
    }
    return motion_rows_close(m, &rows, err);
}

bool motion_send_places(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t parts,
                        duet_error *err)
{
    bool ok = true;
    if (n == 0)
        return true;
    for (size_t i = 0; ok && i < sizeof sent / sizeof sent[0]; ++i)
        if ((parts & sent[i].parts) && motion_words(m, sent[i].which) > 0)
            ok = send_some(m, places, n, i, err);
    return ok && (!(parts & PART_POSE) || !m->cells || send_some_cells(m, places, n, err)) &&
           (!(parts & PART_FILTER) || !motion_has(m, DUET_EFFECT_FILTER) ||
            send_some_filters(m, places, n, err));
}

// A buffer of more rows that keeps what it has; new rows are 0.
static bool grow(duet_motion *m, motion_buffer which, uint32_t old_n, duet_error *err)
{
    size_t words = motion_words(m, which), row = words * sizeof(uint32_t);
    size_t kept = old_n * row, bytes = ((size_t)m->n + MOTION_WALLS) * row;
    buffer *b = &m->buffers[which];
    buffer fresh = {0};
    if (b->bytes < bytes) {
        size_t roomy = bytes + bytes / 4;
        if (!buffer_reserve(&fresh, m->device,
                            roomy <= m->device->info.max_buffer_bytes ? roomy : bytes, err))
            return false;
        cl_int code = kept == 0 ? CL_SUCCESS
                                : clEnqueueCopyBuffer(m->device->queue, b->mem, fresh.mem, 0, 0,
                                                      kept, 0, NULL, NULL);
        if (code == CL_SUCCESS)
            code = clFinish(m->device->queue);
        if (code != CL_SUCCESS) {
            buffer_release(&fresh);
            return error_set_cl(err, code, "%s: copying %zu bytes", m->device->info.selector, kept);
        }
        buffer_swap(b, &fresh);
        buffer_release(&fresh);
    }
    return timeline_fill(&m->times, "clear", b, 0, old_n * words,
                         ((size_t)m->n + MOTION_WALLS) * words, err);
}

bool motion_grow(duet_motion *m, uint32_t old_n, duet_error *err)
{
    bool ok = true;
    for (int which = 0; ok && which < MOTION_BUFFERS; ++which)
        if (motion_words(m, (motion_buffer)which) > 0)
            ok = grow(m, (motion_buffer)which, old_n, err);
    return ok && timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- back

void motion_given_state(const duet_motion *m, uint32_t id, duet_state *state)
{
    entry rotation = rotation_of(m, id), angular = angular_velocity_of(m, id);
    memcpy(state->rotation, rotation.at, sizeof state->rotation);
    memcpy(state->angular_velocity, angular.at, sizeof state->angular_velocity);
}

// Four numbers of each object, or what was given where the buffer is not
// called for.
static bool fetch(duet_motion *m, motion_buffer which,
                  entry (*given)(const duet_motion *, uint32_t), entry *entries, duet_error *err)
{
    if (motion_words(m, which) == 0) {
        for (uint32_t id = 0; id < m->n; ++id)
            entries[id] = given(m, id);
        return true;
    }
    size_t numbers = (size_t)m->n * 4;
    size_t bytes = numbers * (m->def.doubles ? sizeof(double) : sizeof(float));
    const buffer *b = &m->buffers[which];
    void *host = b->host ? b->host : malloc(bytes + 1);
    if (!host)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", bytes);
    bool ok = timeline_read(&m->times, "fetch", &m->buffers[which], host, bytes, err);
    for (size_t i = 0; ok && i < numbers; ++i)
        entries[i / 4].at[i % 4] =
            m->def.doubles ? ((const double *)host)[i] : (double)((const float *)host)[i];
    if (!b->host)
        free(host);
    return ok;
}

// Centres were read as offsets.
static bool add_cells(duet_motion *m, duet_state *states, duet_error *err)
{
    size_t bytes = (size_t)m->n * sizeof(cl_int4);
    const buffer *b = &m->buffers[CELLS];
    cl_int4 *host = b->host ? b->host : malloc(bytes + 1);
    if (!host)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", bytes);
    bool ok = timeline_read(&m->times, "fetch", &m->buffers[CELLS], host, bytes, err);
    for (uint32_t id = 0; ok && id < m->n; ++id)
        for (uint32_t k = 0; k < m->def.dims; ++k)
            states[id].centre[k] += (double)host[id].s[k] * m->def.origin_edge;
    if (!b->host)
        free(host);
    return ok;
}

// What no longer is a number is told here at the latest.
static bool check_finite(const duet_motion *m, const duet_state *states, duet_error *err)
{
    const size_t numbers = sizeof *states / sizeof(double);
    for (uint32_t id = 0; id < m->n; ++id)
        for (size_t k = 0; k < numbers; ++k)
            if (!isfinite(((const double *)&states[id])[k]))
                return error_set(err, DUET_STATUS_BAD_OBJECT,
                                 "object %u of %u: its state after step %llu is not finite", id,
                                 m->n, (unsigned long long)m->step);
    return true;
}

// With offsets for centres.
static bool fetch_states(duet_motion *m, duet_state *states, duet_error *err)
{
    static const struct {
        motion_buffer which;
        entry (*given)(const duet_motion *, uint32_t);
        size_t at;
        size_t numbers;
    } parts[] = {
        {CENTRES, centre_of, offsetof(duet_state, centre), 3},
        {ROTATIONS, rotation_of, offsetof(duet_state, rotation), 4},
        {VELOCITIES, velocity_of, offsetof(duet_state, velocity), 3},
        {ANGULAR_VELOCITIES, angular_velocity_of, offsetof(duet_state, angular_velocity), 3},
    };
    entry *entries = calloc((size_t)m->n + 1, sizeof *entries);
    if (!entries)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u states", m->n);
    bool ok = timeline_finish(&m->times, err);
    for (size_t i = 0; ok && i < sizeof parts / sizeof parts[0]; ++i) {
        ok = fetch(m, parts[i].which, parts[i].given, entries, err);
        for (uint32_t id = 0; ok && id < m->n; ++id)
            memcpy((char *)&states[id] + parts[i].at, entries[id].at,
                   parts[i].numbers * sizeof(double));
    }
    free(entries);
    return ok;
}

bool duet_motion_get_states(duet_motion *m, duet_state *states, duet_error *err)
{
    return motion_is_whole(m, __func__, err) &&
           (m->n == 0 || error_given(states, __func__, "states", err)) &&
           fetch_states(m, states, err) && (!m->cells || add_cells(m, states, err)) &&
           timeline_finish(&m->times, err) && check_finite(m, states, err);
}

bool motion_get_offsets(duet_motion *m, duet_state *states, cl_int4 *cells, duet_error *err)
{
    return fetch_states(m, states, err) &&
           timeline_read(&m->times, "fetch", &m->buffers[CELLS], cells, m->n * sizeof *cells,
                         err) &&
           timeline_finish(&m->times, err) && check_finite(m, states, err);
}

// ---------------------------------------------------------------- sums

static duet_state *read_states(duet_motion *m, duet_error *err)
{
    duet_state *states = calloc((size_t)m->n + 1, sizeof *states);
    if (!states) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u states", m->n);
        return NULL;
    }
    if (duet_motion_get_states(m, states, err))
        return states;
    free(states);
    return NULL;
}

bool motion_check_states(duet_motion *m, duet_error *err)
{
    duet_state *states = read_states(m, err);
    free(states);
    return states;
}

// -0 counts as 0: which of the two a sum of nothing is does not matter.
static uint64_t mix(uint64_t sum, double value, uint64_t place)
{
    double plain = value + 0.0;
    uint64_t k;
    memcpy(&k, &plain, sizeof k);
    k ^= place * UINT64_C(0x9E3779B97F4A7C15);
    k *= UINT64_C(0xBF58476D1CE4E5B9);
    k ^= k >> 29;
    k *= UINT64_C(0x94D049BB133111EB);
    return sum + (k ^ k >> 32);
}

bool duet_motion_get_hash(duet_motion *m, uint64_t *hash, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !error_given(hash, __func__, "hash", err))
        return false;
    duet_state *states = read_states(m, err);
    if (!states)
        return false;
    const size_t numbers = sizeof *states / sizeof(double);
    const double *values = (const double *)states;
    *hash = 0;
    for (size_t i = 0; i < m->n * numbers; ++i)
        *hash = mix(*hash, values[i], i + 1);
    free(states);
    return true;
}

// Axis k of a box turned by q, |q| = 1.
static void axis_of(const double q[4], int k, double axis[3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double columns[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
    };
    memcpy(axis, columns[k], sizeof columns[k]);
}

static double potential_of(const duet_motion_def *def, const duet_state *s, double mass)
{
    if (def->attraction != 0.0) {
        double to[3] = {def->centre[0] - s->centre[0], def->centre[1] - s->centre[1],
                        def->dims == 3 ? def->centre[2] - s->centre[2] : 0.0};
        return -mass * def->attraction / sqrt(vector_dot(to, to, 3));
    }
    return -mass * vector_dot(def->gravity, s->centre, 3);
}

static void add_object(const duet_motion *m, uint32_t id, const duet_state *s, duet_energy *e)
{
    double mass = m->bodies[id].mass;
    entry inverse = inertia_of(m, id);
    double swing[3];
    vector_cross(s->centre, s->velocity, swing);
    e->kinetic += 0.5 * mass * vector_dot(s->velocity, s->velocity, 3);
    if (motion_has(m, DUET_EFFECT_GRAVITY))
        e->potential += potential_of(&m->def, s, mass);
    for (int k = 0; k < 3; ++k) {
        e->momentum[k] += mass * s->velocity[k];
        e->angular[k] += mass * swing[k];
    }
    for (int k = 0; k < 3; ++k) {
        double axis[3];
        axis_of(s->rotation, k, axis);
        double along = vector_dot(axis, s->angular_velocity, 3);
        double inertia = inverse.at[k] > 0.0 ? 1.0 / inverse.at[k] : 0.0;
        e->turning += 0.5 * inertia * along * along;
        for (int j = 0; j < 3; ++j)
            e->angular[j] += inertia * along * axis[j];
    }
}

bool duet_motion_get_energy(duet_motion *m, duet_energy *energy, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !error_given(energy, __func__, "energy", err))
        return false;
    duet_state *states = read_states(m, err);
    if (!states)
        return false;
    *energy = (duet_energy){0};
    for (uint32_t id = 0; id < m->n; ++id)
        if (m->bodies[id].mass > 0.0f && !motion_is_hidden(m, id))
            add_object(m, id, &states[id], energy);
    free(states);
    return true;
}
