// SPDX-License-Identifier: MIT
// The state of a motion on B: what each buffer holds by object, and what the host writes there.
#include "runtime/dynamics/inertia.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"

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

// Of a solid body; one without extent across an axis is never turned about it.
void motion_inverse_inertia(const duet_motion *m, uint32_t id, double inverse[3])
{
    const duet_body *b = &m->bodies[id];
    bool fixed = b->fixed_rotation || motion_is_hidden(m, id);
    inertia_inverse(m->poses[id].half_extents, b->radius, fixed ? 0.0 : (double)b->mass,
                    m->def.dims, inverse);
}

static entry inertia_of(const duet_motion *m, uint32_t id)
{
    entry inverse = {{0}};
    motion_inverse_inertia(m, id, inverse.at);
    return inverse;
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

void motion_given_state(const duet_motion *m, uint32_t id, duet_state *state)
{
    entry rotation = rotation_of(m, id), angular = angular_velocity_of(m, id);
    memcpy(state->rotation, rotation.at, sizeof state->rotation);
    memcpy(state->angular_velocity, angular.at, sizeof state->angular_velocity);
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

// A buffer that must grow gets more than it needs now: fresh pages cost as much time as
// writing them.
bool motion_reserve(duet_motion *m, motion_buffer which, uint64_t n, size_t size, duet_error *err)
{
    buffer *b = &m->buffers[which];
    uint64_t bytes = n * size;
    uint64_t roomy = bytes + bytes / 4;
    bool grows = b->mem && b->bytes < bytes && roomy <= m->device->info.max_buffer_bytes;
    return buffer_reserve(b, m->device, (size_t)(grows ? roomy : bytes), err);
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

// ---------------------------------------------------------------- some rows

static bool map_rows(duet_motion *m, motion_rows *rows, size_t at, duet_error *err)
{
    const device *d = m->device;
    cl_int code = CL_SUCCESS;
    ++m->times.n_waits;
    rows->bytes = clEnqueueMapBuffer(d->queue, rows->of->mem, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE,
                                     at, rows->size, 0, NULL, NULL, &code);
    if (!rows->bytes)
        return error_set_cl(err, code, "%s: mapping %zu bytes", d->info.selector, rows->size);
    rows->mapped_by = d->queue;
    return true;
}

static bool fetch_rows(duet_motion *m, motion_rows *rows, size_t at, duet_error *err)
{
    rows->bytes = malloc(rows->size + 1);
    if (!rows->bytes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", rows->size);
    bool ok = timeline_read_at(&m->times, "fetch", rows->of, at, rows->bytes, rows->size, err);
    if (!ok)
        motion_rows_drop(rows);
    return ok;
}

static bool open_rows(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      uint32_t words, bool doubles, motion_rows *rows, duet_error *err)
{
    size_t row = words * sizeof(uint32_t);
    buffer *b = &m->buffers[which];
    *rows = (motion_rows){
        .of = b, .first = first, .row = row, .size = (last - first) * row, .doubles = doubles};
    return b->host && rows->size > 0 ? map_rows(m, rows, first * row, err)
                                     : fetch_rows(m, rows, first * row, err);
}

bool motion_rows_open(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      motion_rows *rows, duet_error *err)
{
    bool doubles = by_object[which].reals > 0 && m->def.doubles;
    return open_rows(m, which, first, last, motion_words(m, which), doubles, rows, err);
}

bool motion_rows_at(duet_motion *m, motion_buffer which, const uint32_t *places, uint32_t n,
                    motion_rows *rows, duet_error *err)
{
    uint32_t first = UINT32_MAX, last = 0;
    for (uint32_t i = 0; i < n; ++i) {
        first = places[i] < first ? places[i] : first;
        last = places[i] >= last ? places[i] + 1 : last;
    }
    return motion_rows_open(m, which, first, last, rows, err);
}

bool motion_rows_of_contacts(duet_motion *m, motion_buffer which, uint32_t words, motion_rows *rows,
                             duet_error *err)
{
    return open_rows(m, which, 0, m->n_contacts, words, false, rows, err);
}

// What is mapped is the device's again before the queue's next command.
bool motion_rows_close(duet_motion *m, motion_rows *rows, duet_error *err)
{
    size_t at = rows->first * rows->row;
    bool ok = rows->mapped_by ||
              (timeline_write_at(&m->times, "send", rows->of, at, rows->bytes, rows->size, err) &&
               timeline_finish(&m->times, err));
    motion_rows_drop(rows);
    return ok;
}

void motion_rows_drop(motion_rows *rows)
{
    if (rows->mapped_by)
        clEnqueueUnmapMemObject(rows->mapped_by, rows->of->mem, rows->bytes, 0, NULL, NULL);
    else
        free(rows->bytes);
    *rows = (motion_rows){0};
}

// ---------------------------------------------------------------- some objects

static bool send_some_cells(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_rows rows;
    if (!motion_rows_at(m, CELLS, places, n, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        memcpy(motion_row(&rows, places[i]), &m->cells[places[i]], sizeof *m->cells);
    return motion_rows_close(m, &rows, err);
}

static bool send_some_filters(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_rows rows;
    if (!motion_rows_at(m, FILTERS, places, n, &rows, err))
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
    motion_rows rows;
    if (!motion_rows_at(m, sent[what].which, places, n, &rows, err))
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
