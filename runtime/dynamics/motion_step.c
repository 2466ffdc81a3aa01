// SPDX-License-Identifier: MIT
// A time step: what its kernels are told, and the stages that its effects call for, in order.
//
// In two halves a thread of the motion's own takes the step while the caller works. Only the second
// half changes what a caller may ask meanwhile.
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_targets.h"
#include "runtime/dynamics/recorded_steps.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/bodies/ground_def.h"

#include <math.h>
#include <string.h>

// ---------------------------------------------------------------- arguments

static cl_float4 float4_of(double x, double y, double z, double w)
{
    return (cl_float4){{(float)x, (float)y, (float)z, (float)w}};
}

static arg_real real_of(const duet_motion *m, double value)
{
    return m->def.doubles ? (arg_real){.d = value} : (arg_real){.f = (float)value};
}

static arg_real4 real4_of(const duet_motion *m, double x, double y, double z, double w)
{
    return m->def.doubles ? (arg_real4){.d = {{x, y, z, w}}}
                          : (arg_real4){.f = float4_of(x, y, z, w)};
}

// The parts of a substep in free flight: one, or of Yoshida's order 4 two outer ones and
// one between them that goes back. Drag comes once a part, or before and after it.
static void set_flight(duet_motion *m, double h)
{
    double root = cbrt(2.0);
    bool parted = m->def.integrator == DUET_INTEGRATOR_YOSHIDA;
    double outer = parted ? h / (2.0 - root) : h;
    double inner = parted ? -h * root / (2.0 - root) : 0.0;
    double share = m->def.integrator == DUET_INTEGRATOR_EULER ? 1.0 : 0.5;
    m->args.times = real4_of(m, outer, inner, 0.0, 0.0);
    m->args.drags =
        real4_of(m, exp(-m->def.drag * share * outer), exp(-m->def.drag * share * inner), 0.0, 0.0);
}

static void set_gravity(duet_motion *m)
{
    const duet_motion_def *d = &m->def;
    const double *at = d->attraction != 0.0 ? d->centre : d->gravity;
    double z = d->dims == 3 ? at[2] : 0.0;
    m->args.gravity = real4_of(m, at[0], at[1], z, d->attraction);
    m->args.gravity_float = float4_of(at[0], at[1], z, d->attraction);
}

// A damped spring, implicitly: how fast overlap is pushed out per depth, what part of the
// mass answers, and what part of the impulse decays.
static cl_float4 spring_of(const duet_motion *m, double h, double hertz)
{
    const double damping = 10.0;
    double omega = 2.0 * 3.14159265358979323846 * hertz;
    double stiff = 2.0 * damping + h * omega;
    double soft = h * omega * stiff;
    double part = 1.0 / (1.0 + soft);
    return float4_of(omega / stiff, soft * part, part, m->def.max_push_speed);
}

// Sets what the contacts of a substep are solved with.
static void set_solver(duet_motion *m, double h)
{
    const duet_motion_def *d = &m->def;
    // Six substeps a swing, and five against what never moves: fewer than 4.5 shake what they hold.
    m->args.spring = spring_of(m, h, 1.0 / (6.0 * h));
    m->args.hard_spring = spring_of(m, h, 1.0 / (5.0 * h));
    m->args.least_speed = (float)d->restitution_threshold;
    m->args.soon = (float)(0.5 / h);
    // The velocity that a substep adds to all that falls, and 1 / its time. An attraction, which
    // differs from place to place, is left out.
    double part = d->attraction != 0.0 ? 0.0 : h;
    m->args.fall = float4_of(part * d->gravity[0], part * d->gravity[1],
                             d->dims == 3 ? part * d->gravity[2] : 0.0, 1.0 / h);
    // The speed that a load adds to a closing speed in a substep. Less than a slop in a step is
    // rest.
    const cl_float *fall = m->args.fall.s;
    double speed = sqrt(fall[0] * fall[0] + fall[1] * fall[1] + fall[2] * fall[2]);
    m->args.load_speed = (float)(speed + m->margin / MOTION_SLOPS / d->dt);
}

// Walls are far away if there are none.
static void set_walls(duet_motion *m)
{
    const duet_motion_def *d = &m->def;
    const double far = 1e30;
    bool any = d->boundary != DUET_BOUNDARY_NONE;
    m->args.lower = any ? real4_of(m, d->lower[0], d->lower[1], d->lower[2], 0.0)
                        : real4_of(m, -far, -far, -far, 0.0);
    m->args.upper = any ? real4_of(m, d->upper[0], d->upper[1], d->upper[2], 0.0)
                        : real4_of(m, far, far, far, 0.0);
}

// Sets the steps that bounds last for bodies that keep their velocities, and how many skins they
// reach ahead at most, which bounds them for those that are fast. A search is of all bodies,
// further bounds cost those that are awake. What leaves the cells that the grid has for most bodies
// is looked for by all: more steps for more than very few bodies cost more than they save.
static void set_horizon(duet_motion *m)
{
    const double least = LEAST_HORIZON, most_steps = 256.0, most_skins = 64.0;
    bool known = product_was_made(&m->products, PRODUCT_AWAKE) && m->awake.n_bodies > 0;
    double part = known ? (double)m->awake.n_bodies / m->n : 1.0;
    m->args.horizon = real_of(m, fmax(least, fmin(least / sqrt(part), most_steps)));
    m->args.skins = real_of(m, fmax(least, fmin(least / sqrt(part), most_skins)));
}

static void set_args(duet_motion *m)
{
    const duet_motion_def *d = &m->def;
    double h = d->dt / d->substeps;
    double skin = motion_skin(m);
    m->args = (motion_args){
        .substeps = d->substeps,
        .dt = (float)d->dt,
        .dt_real = real_of(m, d->dt),
        .h = (float)h,
        .per_h = (float)(1.0 / h),
        .drag = (float)exp(-d->drag * h),
        .margin = (float)m->margin,
        .skin = real_of(m, skin),
        // Separations up to the margin are contacts, so each object's bounds have half of it.
        .aabb_margin = real_of(m, 0.5 * (m->margin + skin)),
        .contact_margin = real_of(m, 0.5 * m->margin),
        .sleep_speed = (float)d->sleep_speed,
        .sleep_after = (float)d->sleep_after,
        .hit_speed = (float)d->hit_speed,
        .key_end = KEYS,
        .base = m->cells ? m->cells[0] : (cl_int4){{0}},
    };
    set_horizon(m);
    set_walls(m);
    set_flight(m, h);
    set_gravity(m);
    set_solver(m, h);
}

// ---------------------------------------------------------------- products

static bool make_manifolds(duet_motion *m, duet_error *err)
{
    return motion_begin_manifolds(m, err) && motion_end_manifolds(m, err);
}

static bool make_colours(duet_motion *m, duet_error *err)
{
    return motion_begin_colours(m, err) && motion_end_colours(m, err);
}

// Makes a product, after those before it, if it is not right. Altered bodies come first: a check of
// bounds is of all bodies.
static bool ensure(duet_motion *m, product_name which, duet_error *err)
{
    static bool (*const make[PRODUCTS])(duet_motion *, duet_error *) = {
        [PRODUCT_BODIES] = motion_bound_altered, [PRODUCT_BOUNDS] = motion_make_bounds,
        [PRODUCT_PAIRS] = motion_make_pairs,     [PRODUCT_ROWS] = motion_make_rows,
        [PRODUCT_AWAKE] = motion_make_awake,     [PRODUCT_MANIFOLDS] = make_manifolds,
        [PRODUCT_COLOURS] = make_colours,
    };
    return (which == PRODUCT_BODIES || ensure(m, which - 1, err)) &&
           (product_is_right(&m->products, which) || make[which](m, err));
}

// ---------------------------------------------------------------- a step

static bool pushes(const duet_motion *m)
{
    return m->effects & DUET_EFFECT_CONTACT_RESPONSE;
}

// Without response each body flies free, and where it then touches is looked at afterwards.
static bool fly(duet_motion *m, duet_error *err)
{
    products_move_bodies(&m->products);
    return motion_launch(m, INTEGRATE_FREE_FLIGHT, err) &&
           (!(m->effects & DUET_EFFECT_CONTACT) ||
            (ensure(m, PRODUCT_MANIFOLDS, err) && motion_note_events(m, err)));
}

// Contacts are found and parted so often at most.
enum { PARTINGS = 16 };

static bool begin_apart(duet_motion *m, duet_error *err)
{
    bool ok = true, parted = m->step == 0 && (m->effects & DUET_EFFECT_DEPENETRATION);
    for (int i = 0; ok && parted && i < PARTINGS; ++i)
        ok = ensure(m, PRODUCT_MANIFOLDS, err) && motion_part_deep(m, &parted, err);
    return ok;
}

// Reads what the step leaves to be known: whether bounds still hold, what sleeps, and how many
// events.
static bool read_end(duet_motion *m, duet_error *err)
{
    bool checked = pushes(m) && m->kernels.of[CHECK_FAT_AABBS];
    return (!checked && !(m->effects & (DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS))) ||
           motion_read_flags(m, err);
}

static bool send_end(duet_motion *m, bool presses, duet_error *err)
{
    return motion_solve(m, err) && motion_note_events(m, err) && motion_finalize(m, presses, err) &&
           motion_check_bounds(m, false, err);
}

static bool end_response(duet_motion *m, duet_error *err)
{
    const bool presses = m->graph.n_contacts > 0 && m->flags[FLAG_PRESSED];
    return send_end(m, presses, err) && read_end(m, err);
}

// ---------------------------------------------------------------- sent whole

// The device has no work while the host waits for it. So a step whose contacts are known is sent
// whole, and the host looks at the flags once all is sent. It hopes that the step goes as the last
// one did; kernels behind the first that finds otherwise do nothing (kernels/dynamics/records.h),
// and the host goes on from there.
//
//     manifolds -> lists of what woke -> colours -> substeps -> end -> flags and colours are read
//         ^                                ^        \_____________/
//         |  something woke                |  another hope was vain: these did nothing
//         +--------------------------------+------------------------------------ go_on

// Whether a product and all before it are right, but for the bodies.
static bool hold_up_to(const duet_motion *m, product_name which)
{
    return which == PRODUCT_BODIES ||
           (product_is_right(&m->products, which) && hold_up_to(m, which - 1));
}

// The hopes of a step, from the flags of the one before; 0: it is not sent whole. Colours that more
// than one launch makes have to stay; manifolds that a step begins with are not made again.
static cl_uint hopes_of(const duet_motion *m, const uint32_t flags[FLAGS])
{
    const bool lays = m->kernels.of[COLOUR_CONTACTS];
    const bool stays =
        !product_is_forgotten(&m->products, PRODUCT_COLOURS) && !flags[FLAG_RECOLOURED];
    if (m->graph.n_contacts == 0 || m->buffers[BLOCKS].bytes == 0 || !motion_solves_at_once(m) ||
        !(lays || stays) || product_is_right(&m->products, PRODUCT_MANIFOLDS))
        return 0;
    return HOPES_FITS | (lays ? 0 : HOPES_COLOURS) | (flags[FLAG_FELL_ASLEEP] ? 0 : HOPES_AWAKE) |
           (flags[FLAG_PRESSED] ? 0 : HOPES_UNPRESSED);
}

// As kernels ask it, of flags and hopes.
static bool is_vain(const uint32_t flags[FLAGS], cl_uint hopes)
{
    return WAITS_FOR_HOST;
}

// Lists of some bodies take in what woke, so the host waits here unless it hopes that nothing did.
// Without lists that spares two launches.
static bool send_manifolds(duet_motion *m, cl_uint *hopes, duet_error *err)
{
    if (!motion_begin_manifolds(m, err))
        return false;
    if (*hopes & HOPES_AWAKE)
        return true;
    if (!motion_end_manifolds(m, err))
        return false;
    if (!m->awake.all_awake)
        *hopes = (*hopes & ~HOPES_UNPRESSED) | (m->flags[FLAG_PRESSED] ? 0 : HOPES_UNPRESSED);
    return true;
}

static bool send_whole(duet_motion *m, cl_uint *hopes, duet_error *err)
{
    bool ok = send_manifolds(m, hopes, err);
    m->solver.hopes = *hopes;
    ok = ok && motion_begin_colours(m, err) && send_end(m, !(*hopes & HOPES_UNPRESSED), err) &&
         motion_read_flags(m, err);
    m->solver.hopes = 0;
    return ok;
}

// No kernel behind what differs has done anything.
static bool go_on(duet_motion *m, cl_uint hopes, duet_error *err)
{
    const uint32_t *flags = m->flags;
    return (!WAITS_FOR_AWAKE || (motion_end_manifolds(m, err) && motion_begin_colours(m, err))) &&
           motion_end_colours(m, err) && end_response(m, err);
}

static bool respond_whole(duet_motion *m, cl_uint hopes, duet_error *err)
{
    return send_whole(m, &hopes, err) &&
           (is_vain(m->flags, hopes) ? go_on(m, hopes, err) : motion_keep_colours(m, err));
}

// With response what touches when the step begins is solved. A step that is to be as the last one
// begins once all of it is sent.
static bool respond(duet_motion *m, duet_error *err)
{
    uint32_t flags[FLAGS];
    memcpy(flags, m->flags, sizeof flags);
    if (!begin_apart(m, err))
        return false;
    const bool alike = hold_up_to(m, PRODUCT_AWAKE);
    if (!ensure(m, PRODUCT_AWAKE, err))
        return false;
    cl_uint hopes = hopes_of(m, flags);
    if (!alike && !m->awake.all_awake)
        hopes &= ~HOPES_AWAKE; // lists that are new are waited for, since nothing has counted them
    const bool holds =
        alike && (hopes & HOPES_AWAKE) && (hopes & HOPES_UNPRESSED) && !flags[FLAG_RECOLOURED];
    bool ok = (!holds || timeline_hold(&m->times, err)) &&
              (hopes ? respond_whole(m, hopes, err)
                     : ensure(m, PRODUCT_COLOURS, err) && end_response(m, err));
    products_move_bodies(&m->products);
    return ok;
}

// A ground that moves comes near to other bodies than a step ago.
static void forget_ground(duet_motion *m)
{
    if (ground_def_carrier(&m->def) > 0)
        product_forget(&m->products, PRODUCT_ROWS);
}

static bool run_effects(duet_motion *m, duet_error *err)
{
    set_args(m);
    forget_ground(m);
    return motion_recall_events(m, err) &&
           (!(m->effects & DUET_EFFECT_CONTACT) ||
            motion_clear(m, "clear", FLAG_WORDS, 0, FLAGS, err)) &&
           (pushes(m) ? respond(m, err) : fly(m, err) && read_end(m, err));
}

static void note_end(duet_motion *m)
{
    if (pushes(m) && m->kernels.of[CHECK_FAT_AABBS])
        motion_note_bounds(m);
    if (m->effects & DUET_EFFECT_SLEEP)
        motion_note_awake(m);
    if ((m->effects & DUET_EFFECT_SLEEP) && !m->flags[FLAG_AWAKE] && !m->flags[FLAG_FELL_ASLEEP])
        product_keep(&m->products, PRODUCT_BODIES);
}

// Nothing is sent to the device if nothing would change.
static bool run_step(duet_motion *m, duet_error *err)
{
    bool moves = m->n > 0 && m->def.dt != 0.0 && m->effects != 0 &&
                 !product_is_right(&m->products, PRODUCT_BODIES);
    if (moves && !run_effects(m, err))
        return false;
    if (moves)
        note_end(m);
    return (!(m->effects & DUET_EFFECT_EVENTS) || motion_find_events(m, moves, err)) &&
           (!moves || timeline_finish(&m->times, err));
}

static void fill_result(duet_motion *m, duet_motion_result *result)
{
    *result = (duet_motion_result){
        .step = m->step,
        .time = (double)m->step * m->def.dt,
        .pairs = m->graph.n_pairs,
        .contacts = m->solver.n_pushing,
        .colours = m->solver.n_colours,
        .rebuilt = product_is_new(&m->products, PRODUCT_ROWS),
        .events = m->told.changes.events,
        .n_events = m->told.changes.n_events,
        .stays = m->told.changes.stays.pairs,
        .n_stays = m->told.changes.stays.n,
        .hits = m->told.hits,
        .n_hits = m->told.n_hits,
        .stages = m->times.stages,
        .n_stages = m->times.n_launches > 0 ? (uint32_t)m->times.n_stages : 0,
        .timed = !m->times.untimed,
    };
}

static bool carry_step(duet_motion *m, double *ms, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    timeline_begin_step(&m->times, m->device, m->def.stage_times ? 0 : m->step);
    m->products.before = m->products.last;
    bool ok = run_step(m, err);
    *ms = clock_ms_since(begun);
    return ok;
}

static bool complete_step(duet_motion *m, bool carried, double ms, duet_motion_result *result,
                          duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    bool made = carried && (!m->commands || (motion_end_commands(m, err) && motion_arrive(m, err)));
    if (!made) {
        timeline_clear(&m->times);
        m->team.stage = 0; // who failed may have left stages that were not counted
    }
    motion_leave_step(m, made);
    if (!made)
        return false;
    ++m->step;
    fill_result(m, result);
    m->times.untimed = true; // work between steps is no step's
    result->total_ms = ms + clock_ms_since(begun);
    recorded_steps_note(m);
    return true;
}

bool duet_motion_advance(duet_motion *m, duet_motion_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    double ms = 0.0;
    if (!motion_is_whole(m, __func__, err) || !error_given(result, __func__, "result", err) ||
        !budget_check(err))
        return false;
    motion_enter_step(m);
    bool carried = carry_step(m, &ms, err);
    return complete_step(m, carried, ms, result, err);
}

// ---------------------------------------------------------------- in two halves

static bool carry(void *arg, duet_error *err)
{
    duet_motion *m = arg;
    return carry_step(m, &m->halves.ms, err);
}

bool duet_motion_advance_begin(duet_motion *m, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !background_open(&m->halves.thread, err))
        return false;
    motion_enter_step(m);
    background_start(&m->halves.thread, carry, m);
    return true;
}

bool duet_motion_advance_end(duet_motion *m, duet_motion_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(m, __func__, "motion", err) || !error_given(result, __func__, "result", err))
        return false;
    if (m->phase != MOTION_STEPPING)
        return bad_argument(
            err, "%s: no step is under way; expected duet_motion_advance_begin first", __func__);
    bool carried = background_end(&m->halves.thread, err);
    return complete_step(m, carried, m->halves.ms, result, err);
}

// ---------------------------------------------------------------- stage by stage

void domain_forget_bounds(duet_motion *m)
{
    product_forget(&m->products, PRODUCT_BOUNDS);
}

bool domain_make_bounds(duet_motion *m, duet_error *err)
{
    set_args(m);
    return m->n == 0 || !m->kernels.of[COMPUTE_FAT_AABBS] || ensure(m, PRODUCT_BOUNDS, err);
}

// Without pairs that a domain would search for, too.
bool domain_fly(duet_motion *m, duet_error *err)
{
    timeline_begin_step(&m->times, m->device, m->step++);
    set_args(m);
    forget_ground(m);
    products_move_bodies(&m->products);
    return m->n == 0 ||
           (motion_launch(m, INTEGRATE_FREE_FLIGHT, err) && timeline_finish(&m->times, err));
}

bool domain_find_contacts(duet_motion *m, duet_error *err)
{
    return m->n == 0 || (motion_clear(m, "clear", FLAG_WORDS, 0, FLAGS, err) &&
                         ensure(m, PRODUCT_MANIFOLDS, err) && domain_note_events(m, err) &&
                         timeline_finish(&m->times, err));
}

bool domain_begin_apart(duet_motion *m, duet_error *err)
{
    if (m->n == 0 || m->step > 0 || !(m->effects & DUET_EFFECT_DEPENETRATION))
        return true;
    timeline_begin_step(&m->times, m->device, m->step);
    set_args(m);
    return motion_clear(m, "clear", FLAG_WORDS, 0, FLAGS, err) && begin_apart(m, err) &&
           timeline_finish(&m->times, err);
}

// All bodies are gone over: what wakes one may be in another domain.
bool domain_begin_step(duet_motion *m, duet_error *err)
{
    timeline_begin_step(&m->times, m->device, m->step);
    m->products.before = m->products.last;
    product_drop(&m->products, PRODUCT_AWAKE);
    m->awake.n_bodies = m->n;
    set_args(m);
    forget_ground(m);
    return m->n == 0 || (motion_clear(m, "clear", FLAG_WORDS, 0, FLAGS, err) &&
                         ensure(m, PRODUCT_AWAKE, err) && domain_find_manifolds(m, err));
}

bool domain_note_touching(duet_motion *m, duet_error *err)
{
    set_args(m);
    return domain_note_events(m, err);
}

bool domain_recall_touching(duet_motion *m, duet_error *err)
{
    return domain_note_touching(m, err) && domain_list_touching(m, err);
}

bool domain_read_flags(duet_motion *m, duet_error *err)
{
    memset(m->flags, 0, sizeof m->flags);
    return m->n == 0 || motion_read_flags(m, err);
}

static bool check_bounds(duet_motion *m, duet_error *err)
{
    if (!motion_check_bounds(m, true, err) || !motion_read_flags(m, err))
        return false;
    motion_note_bounds(m);
    return true;
}

bool domain_end_step(duet_motion *m, duet_error *err)
{
    ++m->step;
    products_move_bodies(&m->products);
    return (m->n == 0 || !m->kernels.of[CHECK_FAT_AABBS] || check_bounds(m, err)) &&
           timeline_finish(&m->times, err);
}

bool domain_is_bounded(const duet_motion *m)
{
    return m->n == 0 || !(m->effects & DUET_EFFECT_CONTACT) ||
           product_is_right(&m->products, PRODUCT_BOUNDS);
}
