// SPDX-License-Identifier: MIT
// All of a step's solving in one launch: as launches its passes would wait for each other longer than they take.
//
// Invariant: bodies and contacts go through the functions of prepare_contacts, integrate_velocities,
// integrate_positions, solve_contacts, apply_restitution and store_impulses, in the same order. Groups
// of several work-items make constraints, and keep impulses, of all colours together, for these know no order.
//
//   pass 0                contacts into blocks
//   2 for each substep    bodies, and then the contacts of each colour: soft in the first, relaxed in the second
//   the one behind them   restitution
//
//   spans      [COLOUR_SPANS] as colour_parts.clh has them
//   to_colour  the end of colours, of which those without contacts are left out
//   from_pass  up to to_pass: of the launch
//   soft       of the pass, whatever the host says

static inline void accelerate_bodies(const state *s, uint2 range)
{
    for (uint k = range.x + get_local_id(0); k < range.y; k += WG)
        integrate_velocity(s, s->bodies, AWAKE_OF(s, k));
}

static inline void move_bodies(const substep *s, uint2 range)
{
#if ANGULAR_VELOCITY
    for (uint k = range.x + get_local_id(0) * LANES; k < range.y; k += WG * LANES) {
        uint ids[LANES];
        word wanted = list_lanes(s, k, range.y, ids);
        integrate_lanes(s, ids, wanted);
    }
#else
    for (uint k = range.x + get_local_id(0); k < range.y; k += WG)
        move_body(s, AWAKE_OF(s, k));
#endif
}

static inline void take_bodies(const state *s, const substep *to_move, bool soft, uint2 range)
{
    if (soft)
        accelerate_bodies(s, range);
    else
        move_bodies(to_move, range);
}

#if WG == 1

// ------------------------------------------------------------ by a team, or by one work-item

#if LANES > 1
// Asks for the points of a block's records, as many as the present block has: neighbours have as many.
static inline void ask_for_points(const source *from, __global const uint *list, int points)
{
    for (uint k = 0; k < LANES; ++k)
        for (int p = 0; p < points; ++p)
            ask_for(from->contacts + (size_t)list[k] * RECORD + HEAD + p * POINT_FLOATS + OF_NORMAL_IMPULSE);
}
#endif

// The impulses of the last substep, while a cache has them.
static inline void store_part(const solver *s, const source *from, const colour_part *part, uint k)
{
#if LANES > 1
    if (k + 2 * LANES <= part->to)
        ask_for_points(from, s->list + part->first + k + LANES,
                       most_points(points_of(constraint_at(s->blocks, part, k))));
#endif
    for (uint i = k; i < min(k + LANES, part->to); ++i)
        store_contact(constraint_at(s->blocks, part, i), s->contacts + (size_t)s->list[part->first + i] * RECORD);
}

static inline void take_contacts(const solver *s, const source *from, const colour_part *part, uint pass)
{
    const uint last = 2 * s->substeps;
    for (uint k = part->from; k < part->to; k += part->stride) {
        if (pass == 0)
            prepare_part(s->blocks, from, from->list, part, k);
        else if (pass > last)
            restore_speeds(constraint_at(s->blocks, part, k), s->bodies, s->fall, s->least_speed);
        else
            solve_part(s, part, k);
        if (pass == last)
            store_part(s, from, part, k);
    }
}

__kernel void solve_substeps(SOLVE_SUBSTEPS_ARGS)
{
    const source from = {SOLVE_SUBSTEPS_VALUES};
    const state to_accelerate = {SOLVE_SUBSTEPS_VALUES};
    const substep to_move = {SOLVE_SUBSTEPS_VALUES};
    solver s = {SOLVE_SUBSTEPS_VALUES};
    sweep parts = SWEEP;
    colour_part part;
    uint2 range;
    if (WAITS_FOR_HOST)
        return;
    const uint end = to_colour > 0 ? min(to_colour, spans[COLOUR_SPANS - 1].x) : 0;
    for (uint pass = from_pass; pass < to_pass; ++pass) {
        s.soft = pass & 1u;
        if (pass > 0 && pass <= 2 * substeps) {
            BEGIN_BODIES(parts, N_AWAKE);
            while (next_bodies(&parts, N_AWAKE, &range))
                take_bodies(&to_accelerate, &to_move, s.soft, range);
            END_PART(parts);
        }
        for (uint colour = 0; colour < end; ++colour) {
            BEGIN_PART(parts, colour);
            while (next_contacts(&parts, &part))
                take_contacts(&s, &from, &part, pass);
            END_PART(parts);
        }
    }
}

#else

// ------------------------------------------------------------ by groups that meet, or by one group

// blocks: the group's part of all
static inline void prepare_all(const solver *s, const source *from, uint end, uint2 blocks)
{
    for (uint colour = 0; colour < end; ++colour) {
        const colour_part part = part_in_blocks(colour, s->spans[colour], blocks);
        for (uint k = part.from; k < part.to; k += part.stride)
            prepare_lanes(constraint_at(s->blocks, &part, k), from, s->list + part.first + k, 1);
    }
}

// Keeps the impulses of the last substep. Returns bits of the colours in which something bounces.
static inline uint store_all(const solver *s, uint end, uint2 blocks)
{
    uint bouncing = 0;
    for (uint colour = 0; colour < end; ++colour) {
        const colour_part part = part_in_blocks(colour, s->spans[colour], blocks);
        for (uint k = part.from; k < part.to; k += part.stride) {
            __global float *constraint = constraint_at(s->blocks, &part, k);
            mask bounces[POINTS];
            store_contact(constraint, s->contacts + (size_t)s->list[part.first + k] * RECORD);
            if (find_bouncing(constraint, get(constraint, IN_RESTITUTION), s->least_speed, bounces))
                bouncing |= 1u << colour;
        }
    }
    return bouncing;
}

// A work-item's part of the colours, one after the other. The constraint of its next contact is loaded before
// the groups meet: nobody else writes to it, and what was stored and what is loaded are waited for together.
typedef struct {
    uint end; // of the colours
    uint4 span;
    colour_part part;
    held_contact held;
} colour_turn;

static inline void hold_part(colour_turn *t, const solver *s, uint colour)
{
    t->span = s->spans[colour];
    t->part = own_part(colour, t->span);
    if (t->part.from < t->part.to)
        hold_contact(&t->held, constraint_at(s->blocks, &t->part, t->part.from));
}

// Adds the impulses that a step begins with to what its first substep begins with.
static inline void warm_held(const held_contact *h, __global float4 *bodies)
{
    pair p = h->p;
    contact_fields all = h->all;
    load_bodies(&p, bodies);
    load_warm_impulses(&p, bodies);
    store_warm_impulses(&p, &all, bodies);
}

static inline void take_turn(colour_turn *t, const solver *s, uint pass)
{
    const colour_part *part = &t->part;
    for (uint k = part->from; k < part->to; k += part->stride) {
        if (pass == 0)
            warm_held(&t->held, s->bodies);
        else
            solve_pass(s, &t->held, constraint_at(s->blocks, part, k));
        if (k + part->stride < part->to)
            hold_contact(&t->held, constraint_at(s->blocks, part, k + part->stride));
    }
}

// Takes all colours, and holds the first again. A group that takes all of two colours alone meets nobody between them.
static inline void take_colours(colour_turn *t, sweep *parts, const solver *s, uint pass)
{
    for (uint colour = 0; colour < t->end; ++colour) {
        const uint next = colour + 1 < t->end ? colour + 1 : 0, count = t->span.y;
        take_turn(t, s, pass);
        hold_part(t, s, next);
        if (next == 0 || !is_of_one(count) || !is_of_one(t->span.y))
            END_PART(*parts);
        else
            barrier(CLK_GLOBAL_MEM_FENCE);
    }
}

static inline void restore_colours(sweep *parts, const solver *s, uint end, uint bouncing)
{
    for (uint colour = 0; colour < end; ++colour) {
        if (!(bouncing >> colour & 1u))
            continue;
        const colour_part part = own_part(colour, s->spans[colour]);
        for (uint k = part.from; k < part.to; k += part.stride)
            restore_speeds(constraint_at(s->blocks, &part, k), s->bodies, s->fall, s->least_speed);
        END_PART(*parts);
    }
}

// Tells the groups in which colours something bounces.
static inline uint share_bouncing(sweep *parts, const solver *s, uint bouncing)
{
#if MEET
    if (bouncing)
        atomic_or(s->team + MEET_BOUNCES, bouncing);
    END_PART(*parts);
    return s->team[MEET_BOUNCES];
#else
    return ~0u;
#endif
}

// Groups take all passes in a launch.
__kernel void solve_substeps(SOLVE_SUBSTEPS_ARGS)
{
    const source from = {SOLVE_SUBSTEPS_VALUES};
    const state to_accelerate = {SOLVE_SUBSTEPS_VALUES};
    const substep to_move = {SOLVE_SUBSTEPS_VALUES};
    solver s = {SOLVE_SUBSTEPS_VALUES};
    sweep parts = SWEEP;
    if (WAITS_FOR_HOST)
        return;
    const uint last = 2 * substeps;
    const uint4 all = to_colour > 0 ? spans[COLOUR_SPANS - 1] : (uint4)(0);
    const uint2 own_blocks = own_range(all.y, 1);
    colour_turn turn = {.end = min(to_colour, all.x)};
#if MEET
    if (get_global_id(0) == 0)
        team[MEET_BOUNCES] = 0;
#endif
    prepare_all(&s, &from, turn.end, own_blocks);
    END_PART(parts);
    if (turn.end > 0)
        hold_part(&turn, &s, 0);
    take_colours(&turn, &parts, &s, 0);
    for (uint pass = 1; pass <= last; ++pass) {
        s.soft = pass & 1u;
        take_bodies(&to_accelerate, &to_move, s.soft, own_range(N_AWAKE, LANES));
        END_PART(parts);
        take_colours(&turn, &parts, &s, pass);
    }
    const uint bouncing = store_all(&s, turn.end, own_blocks);
    if (to_pass > last + 1)
        restore_colours(&parts, &s, turn.end, share_bouncing(&parts, &s, bouncing));
}

#endif
