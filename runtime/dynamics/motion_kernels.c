// SPDX-License-Identifier: MIT
// Which kernels a motion runs, and with which parameters.
#include "runtime/dynamics/motion.h"

#include "runtime/narrowphase/origin.h"

#include <assert.h>
#include <string.h>

// ---------------------------------------------------------------- arguments

#define BUFFER(which, name, type) BIND_BUFFER(duet_motion, name, type, buffers[which])
#define VALUE(name) BIND_VALUE(duet_motion, #name, args.name)

static const binding motion_bindings[] = {
    BUFFER(CENTRES, "centres", "real4 *"),
    BUFFER(CELLS, "cells", "int4 *"),
    BUFFER(VELOCITIES, "velocities", "real4 *"),
    BUFFER(ROTATIONS, "rotations", "real4 *"),
    BUFFER(ANGULAR_VELOCITIES, "angular_velocities", "real4 *"),
    BUFFER(INERTIAS, "inertias", "float4 *"),
    BUFFER(HALVES, "halves", "float4 *"),
    BUFFER(RESTITUTIONS, "restitutions", "float *"),
    BUFFER(FRICTIONS, "frictions", "float *"),
    BUFFER(FILTERS, "filters", "uint2 *"),
    BUFFER(SENSORS, "sensors", "float *"),
    BUFFER(RESTS, "rests", "float *"),
    BUFFER(ASLEEP, "asleep", "uint *"),
    BUFFER(FORCES, "forces", "float4 *"),
    BUFFER(BODIES, "bodies", "float4 *"),
    BUFFER(BOXES, "boxes", "float *"),
    BUFFER(STARTS, "starts", "uint *"),
    BUFFER(RETURN_STARTS, "return_starts", "uint *"),
    BUFFER(USED, "used", "uint *"),
    BUFFER(CHOICES, "choices", "uint *"),
    BUFFER(OTHERS, "others", "uint *"),
    BUFFER(LINKS, "links", "uint2 *"),
    BUFFER(RETURNS, "returns", "uint *"),
    BUFFER(CONTACTS, "contacts", "float *"),
    BUFFER(TOUCHES, "touches", "uint *"),
    BUFFER(COLOUR_OF, "colours", "uint *"),
    BUFFER(OLD_LINKS, "old_links", "uint2 *"),
    BUFFER(OLD_CONTACTS, "old_contacts", "float *"),
    BUFFER(OLD_TOUCHES, "old_touches", "uint *"),
    BUFFER(OLD_COLOURS, "old_colours", "uint *"),
    BUFFER(LIST, "list", "uint *"),
    BUFFER(LIST_KEYS, "keys", "uint *"),
    BUFFER(COLOUR_STARTS, "key_starts", "uint *"),
    BUFFER(SPANS, "spans", "uint4 *"),
    BUFFER(BLOCKS, "blocks", "float *"),
    BUFFER(TOUCHING, "touching", "uint *"),
    BUFFER(HITS, "hits", "uint *"),
    BUFFER(FLAG_WORDS, "flags", "uint *"),
    BIND_BUFFER(duet_motion, "pairs", "uint2 *", args.pairs),
    BIND_BUFFER(duet_motion, "row_starts", "uint *", args.row_starts),
    BIND_BUFFER(duet_motion, "row_values", "uint *", args.row_values),
    BUFFER(READ_IDS, "ids", "uint *"),
    BUFFER(GATHERED, "gathered", "uint *"),
    BUFFER(CHANGED, "changed", "uint *"),
    BIND_BUFFER(duet_motion, "rows", "uint *", args.rows),
    BIND_BUFFER(duet_motion, "last_rows", "uint *", args.last_rows),
    BIND_BUFFER(duet_motion, "poses", "float *", args.poses),
    BUFFER(PAIRS, "found_pairs", "uint2 *"),
    BUFFER(ALTERED, "altered", "uint *"),
    BUFFER(IS_ALTERED, "is_altered", "uint *"),
    BUFFER(ALTERED_HEADS, "heads", "uint *"),
    BUFFER(ALTERED_ENTRIES_OF, "entries", "int4 *"),
    BUFFER(ALTERED_NEXTS, "nexts", "uint *"),
    BUFFER(ALTERED_WIDE_ONES, "wide", "uint *"),
    BUFFER(ALTERED_COUNT_WORDS, "altered_counts", "uint *"),
    VALUE(n_altered),
    VALUE(n_heads),
    VALUE(per_edge),
    VALUE(pair_capacity),
    VALUE(row_words),
    VALUE(n_ids),
    BIND_VALUE(duet_motion, "n", n),
    BIND_VALUE(duet_motion, "n_contacts", n_contacts),
    BIND_VALUE(duet_motion, "n_keys", n_contacts),
    VALUE(n_pairs),
    VALUE(n_old),
    VALUE(key_end),
    VALUE(gravity),
    BIND_VALUE(duet_motion, "gravity", args.gravity_float),
    VALUE(lower),
    VALUE(upper),
    VALUE(times),
    VALUE(drags),
    VALUE(substeps),
    BIND_VALUE(duet_motion, "dt", args.dt_real),
    VALUE(dt),
    VALUE(h),
    VALUE(per_h),
    VALUE(drag),
    VALUE(spring),
    VALUE(hard_spring),
    VALUE(fall),
    VALUE(load_speed),
    VALUE(margin),
    VALUE(aabb_margin),
    VALUE(contact_margin),
    VALUE(skin),
    VALUE(least_speed),
    VALUE(sleep_speed),
    VALUE(sleep_after),
    VALUE(hit_speed),
    VALUE(base),
    VALUE(fill),
    VALUE(woken),
    VALUE(soft),
    VALUE(span),
    VALUE(round),
    VALUE(from_colour),
    VALUE(to_colour),
    VALUE(each),
    {0}};

// ---------------------------------------------------------------- parameters

enum { MOST_PARAMS = 32 };

static const gen_param *find_param(const gen_param *params, uint32_t n, const char *name)
{
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, name) == 0)
            return &params[i];
    return NULL;
}

// As kernels' settings are: 0 or 1.
static bool has(const duet_motion *m, uint32_t effect)
{
    return m->effects & effect;
}

static int64_t gravity_kind(const duet_motion *m)
{
    return !has(m, DUET_EFFECT_GRAVITY) ? 0 : m->def.attraction != 0.0 ? 2 : 1;
}

// With response, walls are contacts and nothing is left to a free flight.
static int64_t boundary_kind(const duet_motion *m)
{
    return !has(m, DUET_EFFECT_BOUNDARY) ? 0 : m->def.boundary == DUET_BOUNDARY_PERIODIC ? 2 : 1;
}

static int64_t order_of(duet_integrator integrator)
{
    static const int64_t orders[] = {
        [DUET_INTEGRATOR_EULER] = 1, [DUET_INTEGRATOR_VERLET] = 2, [DUET_INTEGRATOR_YOSHIDA] = 4};
    return orders[integrator];
}

// Kernels that know no difference take what turns far as what turns.
static int64_t turning_kind(const duet_motion *m)
{
    return !has(m, DUET_EFFECT_ANGULAR_VELOCITY) ? 0 : has(m, DUET_EFFECT_CONTINUOUS) ? 2 : 1;
}

static gen_setting setting_of(const gen_param *p, int64_t value)
{
    int64_t most = p->is_range ? p->most : p->values[p->n_values - 1];
    return (gen_setting){p->name, value < most ? value : most};
}

// What the scene says of the parameters that the kernel's card has.
static bool gather(duet_motion *m, const char *name, bool altered,
                   gen_setting settings[MOST_PARAMS], uint32_t *n, duet_error *err)
{
    int64_t gyro = has(m, DUET_EFFECT_ANGULAR_VELOCITY) && m->facts.uneven;
    const gen_setting choices[] = {
        {"DIMS", m->def.dims},
        {"DOUBLE", m->def.doubles},
        {"ORIGIN", origin_setting(m->def.origin_edge)},
        {"ORDER", order_of(m->def.integrator)},
        {"ROTATED", has(m, DUET_EFFECT_ROTATION)},
        {"ANGULAR_VELOCITY", turning_kind(m)},
        {"GYRO", gyro},
        {"GRAVITY", gravity_kind(m)},
        {"DRAG", has(m, DUET_EFFECT_DRAG)},
        {"FORCES", has(m, DUET_EFFECT_FORCES)},
        {"BOUNDARY", boundary_kind(m)},
        {"CONTACT_RESPONSE", has(m, DUET_EFFECT_CONTACT_RESPONSE)},
        {"FRICTION", has(m, DUET_EFFECT_FRICTION)},
        {"CONTINUOUS", has(m, DUET_EFFECT_CONTINUOUS)},
        {"FILTER", has(m, DUET_EFFECT_FILTER)},
        {"SLEEP", has(m, DUET_EFFECT_SLEEP)},
        {"SKIN", has(m, DUET_EFFECT_SKIN)},
        {"ROUNDED", has(m, DUET_EFFECT_RADIUS)},
        {"SENSORS", has(m, DUET_EFFECT_SENSORS)},
        {"HITS", motion_tells_hits(m)},
        {"ALTERED", altered},
    };
    const gen_param *params = NULL;
    uint32_t n_params = 0;
    gen_limits limits = program_set_limits(m->programs);
    if (!gen_params(m->gen, name, &limits, &params, &n_params, err))
        return false;
    *n = 0;
    static_assert(sizeof choices / sizeof choices[0] <= MOST_PARAMS, "settings");
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; ++i) {
        const gen_param *p = find_param(params, n_params, choices[i].name);
        if (p)
            settings[(*n)++] = setting_of(p, choices[i].value);
    }
    return true;
}

static bool ask(duet_motion *m, const motion_choice *list, size_t n, duet_error *err)
{
    for (size_t i = 0; i < n; ++i) {
        const motion_choice *c = &list[i];
        gen_setting settings[MOST_PARAMS];
        uint32_t n_settings = 0;
        if (!c->wanted)
            continue;
        if (!gather(m, c->name, c->wanted == MOTION_ALTERED, settings, &n_settings, err))
            return false;
        *c->at = program_set_kernel(m->programs, c->name, c->entry, settings, n_settings,
                                    motion_bindings, err);
        if (!*c->at)
            return false;
    }
    return true;
}

// After a failure none is there.
bool motion_build_kernels(duet_motion *m, const motion_choice *list, size_t n, duet_error *err)
{
    bool ok = *list->at || (ask(m, list, n, err) && program_set_build(m->programs, err));
    for (size_t i = 0; !ok && i < n; ++i)
        *list[i].at = NULL;
    return ok;
}

// ---------------------------------------------------------------- all of them

static motion_layout lay_out(const duet_motion *m)
{
    bool response = has(m, DUET_EFFECT_CONTACT_RESPONSE);
    bool turns = has(m, DUET_EFFECT_ANGULAR_VELOCITY);
    bool friction = has(m, DUET_EFFECT_FRICTION);
    uint32_t dims = m->def.dims;
    uint32_t points = POINTS_OF(response, turns, dims);
    motion_layout l = {
        .head = HEAD_OF(response, turns, points),
        .point = POINT_FLOATS_OF(response, friction, dims),
        .points = points,
        .body = BODY_OF(turns),
    };
    l.record = l.head + l.points * l.point;
    l.constraint = CONSTRAINT_OF(friction, l.points, dims);
    return l;
}

static bool choose_kernels(duet_motion *m, duet_error *err)
{
    motion_kernels *k = &m->kernels;
    bool contact = has(m, DUET_EFFECT_CONTACT);
    bool response = has(m, DUET_EFFECT_CONTACT_RESPONSE);
    bool flight = has(m, DUET_EFFECT_MOTION) && !response;
    bool walls = contact && boundary_kind(m) == 1;
    bool sleep = has(m, DUET_EFFECT_SLEEP), skin = has(m, DUET_EFFECT_SKIN);
    bool events = has(m, DUET_EFFECT_EVENTS);
    const motion_choice list[] = {
        {&k->integrate_free_flight, flight, "integrate_free_flight", "integrate_free_flight"},
        {&k->compute_fat_aabbs, contact, "fat_aabbs", "compute_fat_aabbs"},
        {&k->check_fat_aabbs, skin, "fat_aabbs", "check_fat_aabbs"},
        {&k->contact_graph_pairs, contact, "contact_graph", "contact_graph_pairs"},
        {&k->contact_graph_walls, walls, "contact_graph", "contact_graph_walls"},
        {&k->contact_graph_sort, contact, "contact_graph", "contact_graph_sort"},
        {&k->contact_graph_reverse, contact, "contact_graph", "contact_graph_reverse"},
        {&k->match_contacts, contact, "match_contacts", "match_contacts"},
        {&k->build_manifolds, contact, "build_manifolds", "build_manifolds"},
        {&k->update_sleep, sleep, "update_sleep", "update_sleep"},
        {&k->push_sleepers, sleep, "update_sleep", "push_sleepers"},
        {&k->move_sleepers, sleep, "update_sleep", "move_sleepers"},
        {&k->contact_events, events, "contact_events", "contact_events"},
        {&k->prepare_bodies, response, "bodies", "prepare_bodies"},
        {&k->integrate_velocities, response, "bodies", "integrate_velocities"},
        {&k->integrate_positions, response, "integrate_positions", "integrate_positions"},
        {&k->finalize_bodies, response, "bodies", "finalize_bodies"},
        {&k->graph_colour_mark, response, "graph_colour", "graph_colour_mark"},
        {&k->graph_colour_choose, response, "graph_colour", "graph_colour_choose"},
        {&k->graph_colour_take, response, "graph_colour", "graph_colour_take"},
        {&k->graph_colour_key, response, "graph_colour", "graph_colour_key"},
        {&k->prepare_contacts, response, "prepare_contacts", "prepare_contacts"},
        {&k->store_impulses, response, "prepare_contacts", "store_impulses"},
        {&k->solve_contacts, response, "solve_contacts", "solve_contacts"},
        {&k->apply_restitution, response, "solve_contacts", "apply_restitution"},
        {&k->row_start, response, "cell_start", "row_start"},
    };
    m->layout = lay_out(m);
    if (!ask(m, list, sizeof list / sizeof *list, err))
        return false;
    if (response)
        m->layout.block = (uint32_t)kernel_param(k->solve_contacts, "BLOCK");
    return true;
}

bool motion_prepare(duet_motion *m, duet_error *err)
{
    bool contact = has(m, DUET_EFFECT_CONTACT);
    bool response = has(m, DUET_EFFECT_CONTACT_RESPONSE);
    return choose_kernels(m, err) &&
           (!contact || scan_open(&m->scan, m->device, m->programs, NULL, 0, err)) &&
           (!response ||
            radix_sort_open(&m->radix, m->device, m->programs, &m->scan, NULL, 0, err)) &&
           program_set_build(m->programs, err);
}

// After a failure those before go on.
bool motion_prepare_again(duet_motion *m, duet_error *err)
{
    const motion_kernels before = m->kernels;
    bool ok = choose_kernels(m, err) && program_set_build(m->programs, err);
    if (!ok)
        m->kernels = before;
    return ok;
}
