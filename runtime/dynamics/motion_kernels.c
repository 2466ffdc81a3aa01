// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion.h"

#include "runtime/bodies/ground_def.h"
#include "runtime/narrowphase/origin.h"

#include <string.h>

// ---------------------------------------------------------------- arguments

#define VALUE(name) BIND_VALUE(duet_motion, #name, args.name)
#define VALUE_OF(part, name) BIND_VALUE(duet_motion, #name, part.name)

static const binding motion_bindings[] = {
#define BUFFER(which, name, type) BIND_BUFFER(duet_motion, name, type, buffers[which]),
#define BY_OBJECT(which, name, type, effect, also, reals, words) BUFFER(which, name, type)
#define HIDDEN(which)
#include "runtime/dynamics/motion_buffers.inl"
    BIND_BUFFER(duet_motion, "pairs", "uint2 *", graph.pairs),
    BIND_BUFFER(duet_motion, "row_starts", "uint *", graph.row_starts),
    BIND_BUFFER(duet_motion, "row_values", "uint *", graph.row_values),
    BIND_BUFFER(duet_motion, "rows", "uint *", reading.rows),
    BIND_BUFFER(duet_motion, "row_ids", "uint *", reading.row_ids),
    BIND_BUFFER(duet_motion, "last_rows", "uint *", reading.last_rows),
    BIND_BUFFER(duet_motion, "poses", "float *", poses_to),
    BIND_BUFFER(duet_motion, "ground_values", "float *", ground.buffers[GROUND_VALUES]),
    BIND_BUFFER(duet_motion, "mesh_triangles", "uint *", ground.buffers[GROUND_TRIANGLES]),
    BIND_BUFFER(duet_motion, "mesh_nodes", "uint *", ground.buffers[GROUND_NODES]),
    BIND_VALUE(duet_motion, "ground_origin", ground.origin),
    BIND_VALUE(duet_motion, "ground_spacing", ground.spacing),
    BIND_VALUE(duet_motion, "ground_size", ground.size),
    BIND_VALUE(duet_motion, "ground_surface", ground.surface),
    BIND_VALUE(duet_motion, "carrier", ground.carrier),
    BIND_VALUE(duet_motion, "n_altered", altered.n),
    VALUE_OF(altered, n_heads),
    VALUE_OF(altered, per_edge),
    VALUE_OF(altered, pair_capacity),
    VALUE_OF(reading, row_words),
    VALUE_OF(reading, n_ids),
    VALUE_OF(reading, first_id),
    VALUE_OF(reading, row_parts),
    VALUE_OF(reading, of_four),
    VALUE_OF(border, n_extents),
    VALUE_OF(border, near_capacity),
    VALUE_OF(border, far_time),
    VALUE_OF(border, far_margin),
    VALUE_OF(border, every),
    VALUE_OF(border, listed),
    VALUE_OF(border, n_border),
    VALUE_OF(border, closing_colour),
    BIND_VALUE(duet_motion, "n", n),
    VALUE_OF(graph, n_contacts),
    BIND_VALUE(duet_motion, "n_keys", awake.n_contacts),
    VALUE_OF(graph, n_pairs),
    VALUE_OF(graph, n_old),
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
    VALUE(horizon),
    VALUE(skins),
    VALUE(least_speed),
    VALUE(soon),
    VALUE(sleep_speed),
    VALUE(sleep_after),
    VALUE(hit_speed),
    VALUE(base),
    VALUE_OF(graph, fill),
    VALUE_OF(graph, of_all),
    VALUE_OF(awake, all_awake),
    VALUE_OF(awake, n_parts),
    VALUE_OF(solver, hopes),
    VALUE_OF(solver, woken),
    VALUE_OF(solver, soft),
    VALUE_OF(solver, span),
    VALUE_OF(solver, round),
    VALUE_OF(solver, sweep),
    VALUE_OF(solver, first_sweep),
    VALUE_OF(solver, sorts),
    VALUE_OF(solver, block_capacity),
    VALUE_OF(layout, block),
    VALUE_OF(solver, from_colour),
    VALUE_OF(solver, to_colour),
    VALUE_OF(solver, each),
    VALUE_OF(solver, from_round),
    VALUE_OF(solver, to_round),
    VALUE_OF(solver, from_pass),
    VALUE_OF(solver, to_pass),
    VALUE_OF(team, stage),
    {0}};

// ---------------------------------------------------------------- parameters

// Returns 0 or 1, as kernels' settings are.
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

// A ground lies in 3D, and in no origin cells.
static int64_t ground_kind(const duet_motion *m)
{
    bool has_ground = has(m, DUET_EFFECT_GROUND) && m->def.dims == 3 && m->def.origin_edge == 0.0f;
    return !has_ground ? 0 : m->def.mesh ? 2 : 1;
}

bool motion_touches_walls(const duet_motion *m)
{
    return has(m, DUET_EFFECT_CONTACT) && boundary_kind(m) == 1;
}

bool motion_touches_ground(const duet_motion *m)
{
    return has(m, DUET_EFFECT_CONTACT) && ground_kind(m) > 0;
}

static int64_t has_ground_material(const duet_motion *m)
{
    return ground_kind(m) > 0 && has(m, DUET_EFFECT_MATERIALS) && ground_def_material(&m->def) > 0;
}

static int64_t order_of(duet_integrator integrator)
{
    static const int64_t orders[] = {
        [DUET_INTEGRATOR_EULER] = 1, [DUET_INTEGRATOR_VERLET] = 2, [DUET_INTEGRATOR_YOSHIDA] = 4};
    return orders[integrator];
}

static int64_t turning_kind(const duet_motion *m)
{
    return !has(m, DUET_EFFECT_ANGULAR_VELOCITY) ? 0 : has(m, DUET_EFFECT_CONTINUOUS) ? 2 : 1;
}

bool motion_tells_hits(const duet_motion *m)
{
    return has(m, DUET_EFFECT_EVENTS) && has(m, DUET_EFFECT_CONTACT_RESPONSE) &&
           m->def.hit_speed > 0.0;
}

#define OFFER(name, value)                  \
    {                                       \
        NULL, name, value, GEN_CAPPED, NULL \
    }

// Kernels that know no difference take what turns far as what turns: the greatest value that they
// have.
uint32_t motion_offers(duet_motion *m, bool altered, gen_offer offers[MOTION_OFFERS])
{
    int64_t gyro = has(m, DUET_EFFECT_ANGULAR_VELOCITY) && (m->facts & FACT_UNEVEN);
    const gen_offer of_scene[] = {
        OFFER("DIMS", m->def.dims),
        OFFER("DOUBLE", m->def.doubles),
        OFFER("ORIGIN", origin_setting(m->def.origin_edge)),
        OFFER("ORDER", order_of(m->def.integrator)),
        OFFER("ROTATED", has(m, DUET_EFFECT_ROTATION)),
        OFFER("ANGULAR_VELOCITY", turning_kind(m)),
        OFFER("GYRO", gyro),
        OFFER("GRAVITY", gravity_kind(m)),
        OFFER("DRAG", has(m, DUET_EFFECT_DRAG)),
        OFFER("FORCES", has(m, DUET_EFFECT_FORCES)),
        OFFER("BOUNDARY", boundary_kind(m)),
        OFFER("CONTACT_RESPONSE", has(m, DUET_EFFECT_CONTACT_RESPONSE)),
        OFFER("FRICTION", has(m, DUET_EFFECT_FRICTION)),
        OFFER("ROLLING", has(m, DUET_EFFECT_ROLLING_RESISTANCE)),
        OFFER("CONVEYS", has(m, DUET_EFFECT_SURFACE_VELOCITY)),
        OFFER("MATERIALS", has(m, DUET_EFFECT_MATERIALS)),
        OFFER("GROUND_MATERIAL", has_ground_material(m)),
        OFFER("CONTINUOUS", has(m, DUET_EFFECT_CONTINUOUS)),
        OFFER("FILTER", has(m, DUET_EFFECT_FILTER)),
        OFFER("SLEEP", has(m, DUET_EFFECT_SLEEP)),
        OFFER("SKIN", has(m, DUET_EFFECT_SKIN)),
        OFFER("ROUNDED", has(m, DUET_EFFECT_RADIUS)),
        OFFER("SENSORS", has(m, DUET_EFFECT_SENSORS)),
        OFFER("GROUND", ground_kind(m)),
        OFFER("CARRIED", ground_kind(m) == 2 && ground_def_carrier(&m->def) > 0),
        OFFER("HITS", motion_tells_hits(m)),
        OFFER("ALTERED", altered),
        OFFER("TEAM", m->device->info.kind == DUET_KIND_CPU),
        OFFER("MEET", (m->device->quirks & DRIVER_MEETS) != 0),
    };
    const uint32_t n = sizeof of_scene / sizeof *of_scene;
    _Static_assert(sizeof of_scene / sizeof *of_scene + VARIANT_SETTINGS <= MOTION_OFFERS,
                   "all have space");
    memcpy(offers, of_scene, sizeof of_scene);
    return n + motion_plan_offer(&m->plan, offers + n);
}

// ---------------------------------------------------------------- launches

static const struct {
    const char *entry, *file, *stage;
    bool later;
} rows[MOTION_KERNELS] = {
#define KERNEL(which, entry, file, wanted, stage, work) [which] = {#entry, file, stage, false},
#define LATER(which, entry, file, stage, work) [which] = {#entry, file, stage, true},
#include "runtime/dynamics/motion_kernels.inl"
};

static uint64_t work_of(const duet_motion *m, motion_kernel which)
{
    switch (which) {
#define KERNEL(which, entry, file, wanted, stage, work) \
    case which:                                         \
        return work;
#include "runtime/dynamics/motion_kernels.inl"
    default:
        return 0;
    }
}

static kernel_request request_of(duet_motion *m, motion_kernel which, bool wanted)
{
    return (kernel_request){&m->kernels.of[which], wanted, rows[which].file, rows[which].entry,
                            motion_bindings};
}

static bool ask(duet_motion *m, const kernel_request *list, size_t n, bool altered, duet_error *err)
{
    gen_offer offers[MOTION_OFFERS];
    uint32_t n_offers = motion_offers(m, altered, offers);
    return program_set_kernels(m->programs, list, n, offers, n_offers, err);
}

bool motion_build_ahead(duet_motion *m, motion_kernel which, duet_error *err)
{
    kernel_request list[MOTION_KERNELS];
    size_t n = 0;
    for (int i = 0; i < MOTION_KERNELS; ++i)
        if (rows[i].later && strcmp(rows[i].file, rows[which].file) == 0)
            list[n++] = request_of(m, (motion_kernel)i, true);
    bool ok =
        ask(m, list, n, which == COMPUTE_ALTERED_AABBS, err) && program_set_build(m->programs, err);
    for (size_t i = 0; !ok && i < n; ++i)
        *list[i].at = NULL;
    return ok;
}

bool motion_launch_over(duet_motion *m, motion_kernel which, uint64_t work, duet_error *err)
{
    kernel *const *k = &m->kernels.of[which];
    if (!*k && rows[which].later && !motion_build_ahead(m, which, err))
        return false;
    return !*k || timeline_launch(&m->times, rows[which].stage, *k, work, m, err);
}

bool motion_launch(duet_motion *m, motion_kernel which, duet_error *err)
{
    return motion_launch_over(m, which, work_of(m, which), err);
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
    l.constraint = CONSTRAINT_OF(friction, has(m, DUET_EFFECT_ROLLING_RESISTANCE),
                                 has(m, DUET_EFFECT_SURFACE_VELOCITY), l.points);
    return l;
}

// Asks for those that are not built later.
static bool ask_wanted(duet_motion *m, duet_error *err)
{
    const bool contact = has(m, DUET_EFFECT_CONTACT);
    const bool response = has(m, DUET_EFFECT_CONTACT_RESPONSE);
    const bool flight = has(m, DUET_EFFECT_MOTION) && !response;
    const bool sleep = has(m, DUET_EFFECT_SLEEP), skin = has(m, DUET_EFFECT_SKIN);
    const bool events = has(m, DUET_EFFECT_EVENTS), shocks = has(m, DUET_EFFECT_SHOCKS);
    const bool cpu = m->device->info.kind == DUET_KIND_CPU;
    const bool meets = m->device->quirks & DRIVER_MEETS;
    // Not with shocks, nor if more bodies are always awake than a GPU's group takes.
    const bool at_once = response && !shocks && (cpu || meets || sleep || m->n <= SOLVER_FEW);
    const kernel_request list[] = {
#define KERNEL(which, entry, file, wanted, stage, work) request_of(m, which, wanted),
#define LATER(which, entry, file, stage, work)
#include "runtime/dynamics/motion_kernels.inl"
    };
    return ask(m, list, sizeof list / sizeof *list, false, err);
}

static bool choose_kernels(duet_motion *m, duet_error *err)
{
    m->layout = lay_out(m);
    if (!ask_wanted(m, err) || !motion_plan_is_used(m, err))
        return false;
    if (has(m, DUET_EFFECT_CONTACT_RESPONSE))
        m->layout.block = (uint32_t)kernel_param(m->kernels.of[SOLVE_CONTACTS], "BLOCK");
    return true;
}

bool motion_has_team(const duet_motion *m, motion_kernel which)
{
    const kernel *k = m->kernels.of[which];
    return k && k->groups == GROUPS_TEAM;
}

// Whether one launch colours: by groups that meet, or by a team, unless a plan sets groups for the
// launches.
static bool colours_at_once(const duet_motion *m)
{
    const kernel *k = m->kernels.of[COLOUR_CONTACTS];
    return k && (k->groups == GROUPS_MEET ||
                 (k->groups == GROUPS_TEAM && m->kernels.of[GRAPH_COLOUR_MARK]->group == 1));
}

// A plan that sets how contacts are solved is obeyed by launches of their own.
static bool team_obeys(const duet_motion *m)
{
    return motion_has_team(m, SOLVE_CONTACTS) &&
           kernel_param(m->kernels.of[SOLVE_CONTACTS], "LANES") ==
               kernel_param(m->kernels.of[SOLVE_SUBSTEPS], "LANES");
}

static void spare(const duet_motion *m, const motion_kernel *list, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        kernel_spare(m->kernels.of[list[i]]);
}

static void drop(duet_motion *m, motion_kernel which)
{
    if (m->kernels.of[which])
        kernel_spare(m->kernels.of[which]);
    m->kernels.of[which] = NULL;
}

// Launches that do all of several stages are there only if they are used, and then spare the
// kernels of each stage, unless a domain takes its stages one by one.
static void choose_launches(duet_motion *m)
{
    static const motion_kernel of_solver[] = {PREPARE_CONTACTS, STORE_IMPULSES, SOLVE_CONTACTS,
                                              APPLY_RESTITUTION, INTEGRATE_POSITIONS};
    static const motion_kernel of_colours[] = {GRAPH_COLOUR_MARK, GRAPH_COLOUR_CHOOSE,
                                               GRAPH_COLOUR_TAKE, GRAPH_COLOUR_KEY, ROW_START};
    if (!colours_at_once(m))
        drop(m, COLOUR_CONTACTS);
    if (motion_has_team(m, SOLVE_SUBSTEPS) && !team_obeys(m))
        drop(m, SOLVE_SUBSTEPS);
    if (motion_has_team(m, SOLVE_SUBSTEPS) && !m->is_domain)
        spare(m, of_solver, sizeof of_solver / sizeof *of_solver);
    if (m->kernels.of[COLOUR_CONTACTS] && !m->is_domain) {
        spare(m, of_colours, sizeof of_colours / sizeof *of_colours);
        kernel_spare(m->solver.radix.count);
        kernel_spare(m->solver.radix.move);
    }
}

static bool choose_all(duet_motion *m, duet_error *err)
{
    const kernel_request sorts[] = {
        SCAN_KERNELS(&m->graph.scan, has(m, DUET_EFFECT_CONTACT)),
        RADIX_SORT_KERNELS(&m->solver.radix, has(m, DUET_EFFECT_CONTACT_RESPONSE)),
    };
    bool ok = choose_kernels(m, err) &&
              program_set_kernels(m->programs, sorts, sizeof sorts / sizeof *sorts, NULL, 0, err);
    if (ok)
        choose_launches(m);
    return ok;
}

bool motion_prepare(duet_motion *m, duet_error *err)
{
    m->graph.scan.device = m->solver.radix.device = m->device;
    m->solver.radix.scan = &m->graph.scan;
    return choose_all(m, err) && program_set_build(m->programs, err);
}

// After a failure those before go on.
bool motion_prepare_again(duet_motion *m, duet_error *err)
{
    scan *sums = &m->graph.scan;
    radix_sort *sorts = &m->solver.radix;
    const motion_kernels kernels = m->kernels;
    const motion_layout layout = m->layout;
    const scan of_sums = *sums;
    const radix_sort of_sorts = *sorts;
    bool ok = choose_all(m, err) && program_set_build(m->programs, err);
    product_drop(&m->products, PRODUCT_AWAKE); // bodies may have another layout
    if (!ok) {
        program_set_spare(m->programs);
        m->kernels = kernels;
        m->layout = layout;
        *sums = of_sums;
        *sorts = of_sorts;
    }
    return ok;
}
