// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_state.h"

#include "kernels/dynamics/materials.h"
#include "runtime/bodies/material.h"
#include "runtime/dynamics/inertia.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_rows.h"

#include <math.h>
#include <string.h>

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
    motion_rows rows;
    if (!(places ? motion_rows_at(m, which, places, n, &rows, err)
                 : motion_rows_fresh(m, which, n, &rows, err)))
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
    const motion_rows rows = {.row = motion_words(m, which) * sizeof(uint32_t),
                              .doubles = motion_has_doubles(m, which),
                              .bytes = packed};
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
        if (!sleeps)
            motion_row_set(&rows, places[i], 0, RESTS_CHANGED);
        else if (m->bodies[places[i]].mass > 0.0f)
            motion_row_set(&rows, places[i], 0, rested);
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
    const cl_float rest = RESTS_CHANGED;
    cl_uint changed;
    memcpy(&changed, &rest, sizeof changed);
    products_move_bodies(&m->products);
    product_forget(&m->products, PRODUCT_AWAKE);
    return !(m->effects & DUET_EFFECT_SLEEP) ||
           (timeline_fill(&m->times, "clear", &m->buffers[RESTS], changed, 0, m->n, err) &&
            motion_clear(m, "clear", ASLEEP, 0, m->n, err) && timeline_finish(&m->times, err));
}
