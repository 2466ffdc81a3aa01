// SPDX-License-Identifier: MIT
// The state of a motion on B: what each buffer holds by object, and what the host writes there.
#include "kernels/dynamics/materials.h"
#include "runtime/bodies/material.h"
#include "runtime/dynamics/inertia.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"

#include "base/error.h"
#include "runtime/duet_motion_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// By object, what each buffer holds: the effect that it is there for, another that calls for it,
// reals and 32-bit words.
static const struct {
    uint32_t effect;
    uint32_t also;
    uint32_t reals;
    uint32_t words;
} by_object[MOTION_BUFFERS] = {
#define BY_OBJECT(which, name, type, effect, also, reals, words) \
    [which] = {DUET_EFFECT_##effect, DUET_EFFECT_##also, reals, words},
#define BUFFER(which, name, type)
#define HIDDEN(which)
#include "runtime/dynamics/motion_buffers.inl"
};

const char *duet_state_part_name(duet_state_part part)
{
    static const char *const names[] = {
        [DUET_STATE_CENTRES] = "centres",
        [DUET_STATE_ROTATIONS] = "rotations",
        [DUET_STATE_VELOCITIES] = "velocities",
        [DUET_STATE_ANGULAR_VELOCITIES] = "angular_velocities",
    };
    const int n = sizeof names / sizeof names[0];
    return (int)part >= 0 && (int)part < n ? names[part] : NULL;
}

static bool has_rows(const duet_motion *m, motion_buffer which)
{
    const uint32_t effect = by_object[which].effect, also = by_object[which].also;
    if (which == CELLS)
        return m->cells;
    if (which == FAR_BOXES && !m->border.make_far_boxes)
        return false;
    return also == DUET_EFFECT_ALL || (m->effects & (effect | also));
}

uint32_t motion_words(const duet_motion *m, motion_buffer which)
{
    if (!has_rows(m, which))
        return 0;
    return by_object[which].reals * (m->def.doubles ? 2 : 1) +
           by_object[which].words * (which == BODIES ? m->layout.body : 1);
}

uint32_t motion_bytes_for(const duet_motion *m, uint32_t effect)
{
    uint32_t words = 0;
    for (int which = 0; which < MOTION_BUFFERS; ++which)
        if (by_object[which].effect == effect)
            words += motion_words(m, (motion_buffer)which);
    return words * (uint32_t)sizeof(uint32_t);
}

// ---------------------------------------------------------------- buffers

// A buffer that must grow gets more than it needs now: fresh pages cost as much time as
// writing them.
static size_t with_room(const duet_motion *m, uint64_t bytes)
{
    uint64_t roomy = bytes + bytes / 4;
    return (size_t)(roomy <= m->device->info.max_buffer_bytes ? roomy : bytes);
}

bool motion_reserve(duet_motion *m, motion_buffer which, uint64_t n, size_t size, duet_error *err)
{
    buffer *b = &m->buffers[which];
    bool grows = b->mem && b->bytes < n * size;
    return buffer_reserve(b, m->device, grows ? with_room(m, n * size) : (size_t)(n * size), err);
}

static bool copy(duet_motion *m, const buffer *from, const buffer *to, size_t bytes,
                 duet_error *err)
{
    cl_command_queue queue = m->device->queue;
    cl_int code = clEnqueueCopyBuffer(queue, from->mem, to->mem, 0, 0, bytes, 0, NULL, NULL);
    if (code == CL_SUCCESS)
        code = clFinish(queue);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: copying %zu bytes", m->device->info.selector, bytes);
}

bool motion_extend(duet_motion *m, motion_buffer which, size_t kept, size_t bytes, duet_error *err)
{
    buffer *b = &m->buffers[which], fresh = {0};
    if (b->bytes >= bytes)
        return true;
    bool ok = buffer_reserve(&fresh, m->device, kept > 0 ? with_room(m, bytes) : bytes, err) &&
              (kept == 0 || copy(m, b, &fresh, kept, err));
    if (ok)
        buffer_swap(b, &fresh);
    buffer_release(&fresh);
    return ok;
}

// New rows are 0.
static bool grow(duet_motion *m, motion_buffer which, uint32_t old_n, duet_error *err)
{
    size_t words = motion_words(m, which), row = words * sizeof(uint32_t);
    size_t bytes = ((size_t)m->n + FIXED) * row;
    return motion_extend(m, which, old_n * row, bytes, err) &&
           timeline_fill(&m->times, "clear", &m->buffers[which], 0, old_n * words,
                         bytes / sizeof(uint32_t), err);
}

bool motion_grow_rows(duet_motion *m, motion_buffer which, uint32_t old_n, duet_error *err)
{
    return motion_words(m, which) == 0 || grow(m, which, old_n, err);
}

bool motion_grow(duet_motion *m, uint32_t old_n, duet_error *err)
{
    bool ok = true;
    for (int which = 0; ok && which < MOTION_BUFFERS; ++which)
        ok = motion_grow_rows(m, (motion_buffer)which, old_n, err);
    return ok;
}

// ---------------------------------------------------------------- rows

// Rows of host memory, once all that was launched is done: mapped, or as they lie.
static bool map_rows(duet_motion *m, motion_rows *rows, size_t at, duet_error *err)
{
    const device *d = m->device;
    const buffer *const seen[] = {rows->of};
    cl_int code = CL_SUCCESS;
    if (d->quirks & DRIVER_IN_PLACE) {
        rows->bytes = (char *)rows->of->host + at;
        return m->times.sent == SENT_SEEN || timeline_see(&m->times, "send", seen, 1, err);
    }
    ++m->times.n_waits;
    ++m->times.all_waits;
    rows->bytes = clEnqueueMapBuffer(d->queue, rows->of->mem, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE,
                                     at, rows->size, 0, NULL, NULL, &code);
    if (!rows->bytes)
        return error_set_cl(err, code, "%s: mapping %zu bytes", d->info.selector, rows->size);
    rows->mapped_by = d->queue;
    return true;
}

// Fresh rows are not fetched: all are written before they are sent.
static bool fetch_rows(duet_motion *m, motion_rows *rows, size_t at, bool fresh, duet_error *err)
{
    rows->bytes = malloc(rows->size + 1);
    if (!rows->bytes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", rows->size);
    bool ok =
        fresh || timeline_read_at(&m->times, "fetch", rows->of, at, rows->bytes, rows->size, err);
    if (!ok)
        motion_rows_drop(rows);
    return ok;
}

static bool are_of_host(const motion_rows *rows)
{
    return rows->of && rows->of->host && rows->size > 0;
}

static bool open_rows(duet_motion *m, motion_rows *rows, bool fresh, duet_error *err)
{
    size_t at = rows->first * rows->row;
    return are_of_host(rows) ? map_rows(m, rows, at, err) : fetch_rows(m, rows, at, fresh, err);
}

static motion_rows rows_of(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last)
{
    size_t row = motion_words(m, which) * sizeof(uint32_t);
    return (motion_rows){.of = &m->buffers[which],
                         .first = first,
                         .row = row,
                         .size = (last - first) * row,
                         .doubles = by_object[which].reals > 0 && m->def.doubles};
}

bool motion_rows_open(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      motion_rows *rows, duet_error *err)
{
    *rows = rows_of(m, which, first, last);
    return open_rows(m, rows, false, err);
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

bool motion_rows_of_words(duet_motion *m, motion_buffer which, uint32_t n, uint32_t words,
                          motion_rows *rows, duet_error *err)
{
    size_t row = words * sizeof(uint32_t);
    *rows = (motion_rows){.of = &m->buffers[which], .row = row, .size = n * row};
    return open_rows(m, rows, false, err);
}

// Mapped memory is the device's again before the queue's next command.
bool motion_rows_close(duet_motion *m, motion_rows *rows, duet_error *err)
{
    size_t at = rows->first * rows->row;
    bool ok = are_of_host(rows) ||
              (timeline_write_at(&m->times, "send", rows->of, at, rows->bytes, rows->size, err) &&
               timeline_finish(&m->times, err));
    motion_rows_drop(rows);
    return ok;
}

void motion_rows_drop(motion_rows *rows)
{
    if (rows->mapped_by)
        clEnqueueUnmapMemObject(rows->mapped_by, rows->of->mem, rows->bytes, 0, NULL, NULL);
    else if (!are_of_host(rows))
        free(rows->bytes);
    *rows = (motion_rows){0};
}

// ---------------------------------------------------------------- objects

// The numbers of one object in a buffer: whole numbers as well are exact as doubles.
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

static entry cell_of(const duet_motion *m, uint32_t id)
{
    const cl_int *s = m->cells[id].s;
    return (entry){{s[0], s[1], s[2], s[3]}};
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

// Takes the body as solid; one without extent across an axis is never turned about it.
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
    return (entry){{material_restitution(&m->def, &m->bodies[id])}};
}

static entry friction_of(const duet_motion *m, uint32_t id)
{
    return (entry){{material_friction(&m->def, &m->bodies[id])}};
}

static entry material_of(const duet_motion *m, uint32_t id)
{
    return (entry){{m->bodies[id].material}};
}

static entry rolling_resistance_of(const duet_motion *m, uint32_t id)
{
    return (entry){{m->bodies[id].rolling_resistance}};
}

static entry surface_velocity_of(const duet_motion *m, uint32_t id)
{
    const float *v = m->bodies[id].surface_velocity;
    return (entry){{v[0], v[1], m->def.dims == 3 ? v[2] : 0.0}};
}

static entry filter_of(const duet_motion *m, uint32_t id)
{
    return (entry){{m->bodies[id].group, m->bodies[id].mask}};
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

// The buffers that are sent, and the numbers of an entry that each part has.
static const struct {
    motion_buffer which;
    entry (*of)(const duet_motion *, uint32_t);
    uint32_t parts;
    uint32_t from, to;
    bool whole; // words, not reals
} sent[] = {
    {CENTRES, centre_of, PART_POSE, 0, 4, false},
    {CELLS, cell_of, PART_POSE, 0, 4, true},
    {VELOCITIES, velocity_of, PART_VELOCITY, 0, 3, false},
    {VELOCITIES, velocity_of, PART_MASS, 3, 4, false},
    {ROTATIONS, rotation_of, PART_POSE, 0, 4, false},
    {ANGULAR_VELOCITIES, angular_velocity_of, PART_ANGULAR_VELOCITY, 0, 4, false},
    {INERTIAS, inertia_of, PART_MASS | PART_SIZE, 0, 4, false},
    {HALVES, half_of, PART_SIZE, 0, 4, false},
    {RESTITUTIONS, restitution_of, PART_SURFACE, 0, 1, false},
    {FRICTIONS, friction_of, PART_SURFACE, 0, 1, false},
    {ROLLING_RESISTANCES, rolling_resistance_of, PART_SURFACE, 0, 1, false},
    {SURFACE_VELOCITIES, surface_velocity_of, PART_SURFACE, 0, 4, false},
    {MATERIALS_OF, material_of, PART_SURFACE, 0, 1, true},
    {FILTERS, filter_of, PART_FILTER, 0, 2, true},
    {SENSORS, sensor_of, PART_SENSOR, 0, 1, false},
};

// Writes what a buffer has of an object, up to a number of its entry, to a row.
static void put_entry(const duet_motion *m, size_t what, uint32_t place, uint32_t to,
                      const motion_rows *rows, uint32_t row)
{
    const entry e = sent[what].of(m, place);
    for (uint32_t k = sent[what].from; k < to; ++k)
        if (sent[what].whole)
            ((uint32_t *)motion_row(rows, row))[k] = (uint32_t)(int64_t)e.at[k];
        else
            motion_row_set(rows, row, k, e.at[k]);
}

static uint32_t numbers_of(const motion_rows *rows)
{
    return (uint32_t)(rows->row / (rows->doubles ? sizeof(double) : sizeof(float)));
}

// Sends all objects if places is NULL: their rows are then written whole.
static bool send(duet_motion *m, const uint32_t *places, uint32_t n, size_t what, duet_error *err)
{
    motion_buffer which = sent[what].which;
    motion_rows rows = rows_of(m, which, 0, n);
    if (!(places ? motion_rows_at(m, which, places, n, &rows, err)
                 : open_rows(m, &rows, true, err)))
        return false;
    uint32_t to = places ? sent[what].to : numbers_of(&rows);
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t place = places ? places[i] : i;
        put_entry(m, what, place, to, &rows, place);
    }
    return motion_rows_close(m, &rows, err);
}

void motion_fill_given(duet_motion *m, motion_buffer which, const uint32_t *places, uint32_t n,
                       void *packed)
{
    motion_rows rows = rows_of(m, which, 0, n);
    rows.bytes = packed;
    for (size_t what = 0; what < sizeof sent / sizeof sent[0]; ++what)
        if (sent[what].which == which && sent[what].from == 0)
            for (uint32_t i = 0; i < n; ++i)
                put_entry(m, what, places[i], numbers_of(&rows), &rows, i);
}

bool motion_send_places(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t parts,
                        duet_error *err)
{
    bool ok = true;
    product_forget(&m->products, PRODUCT_AWAKE);
    for (size_t i = 0; ok && n > 0 && i < sizeof sent / sizeof sent[0]; ++i)
        if ((parts & sent[i].parts) && (places || sent[i].from == 0) &&
            motion_words(m, sent[i].which) > 0)
            ok = send(m, places, n, i, err);
    return ok;
}

// The rules by which materials combine, once a motion.
static bool send_rules(duet_motion *m, duet_error *err)
{
    float rules[DUET_MATERIALS * DUET_MATERIALS * MATERIAL_ROW];
    if (!(m->effects & DUET_EFFECT_MATERIALS))
        return true;
    material_fill_rules(&m->def, rules);
    return motion_reserve(m, MATERIAL_RULES, 1, sizeof rules, err) &&
           timeline_write_at(&m->times, "clear", &m->buffers[MATERIAL_RULES], 0, rules,
                             sizeof rules, err) &&
           timeline_finish(&m->times, err);
}

bool motion_reset(duet_motion *m, duet_error *err)
{
    return (!(m->effects & DUET_EFFECT_CONTACT) ||
            motion_reserve(m, FLAG_WORDS, FLAGS, sizeof(uint32_t), err)) &&
           (!(m->effects & DUET_EFFECT_SHOCKS) ||
            motion_reserve(m, SHOCKED, 1, sizeof(uint32_t), err)) &&
           motion_grow(m, 0, err) && send_rules(m, err) &&
           motion_send_places(m, NULL, m->n, PART_ALL, err) && timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- sleep

// A body without mass never sleeps; bodies that touch it are told that it changed.
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

// A body that is sent to sleep is awake for the step that finds it at rest: its contacts are then
// the contacts of where it lies.
static bool mark_awake(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_rows rows;
    if (!motion_rows_at(m, ASLEEP, places, n, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        *(uint32_t *)motion_row(&rows, places[i]) = 0;
    return motion_rows_close(m, &rows, err);
}

bool motion_set_asleep(duet_motion *m, const uint32_t *places, uint32_t n, bool asleep,
                       duet_error *err)
{
    if (n == 0)
        return true;
    product_forget(&m->products, PRODUCT_BODIES);
    product_forget(&m->products, PRODUCT_AWAKE);
    m->awake.changed_in = m->step;
    return !(m->effects & DUET_EFFECT_SLEEP) ||
           (mark_rests(m, places, n, asleep, err) && mark_awake(m, places, n, err));
}

bool motion_wake_places(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err)
{
    if (n > 0)
        products_move_bodies(&m->products);
    return motion_set_asleep(m, places, n, false, err);
}

bool motion_wake_all(duet_motion *m, duet_error *err)
{
    products_move_bodies(&m->products);
    product_forget(&m->products, PRODUCT_AWAKE);
    return !(m->effects & DUET_EFFECT_SLEEP) ||
           (motion_clear(m, "clear", RESTS, 0, m->n, err) &&
            motion_clear(m, "clear", ASLEEP, 0, m->n, err) && timeline_finish(&m->times, err));
}
