// SPDX-License-Identifier: MIT
// All of a step's solving in one launch: as launches its passes would wait for each other longer than they take.
//
// Invariant: bodies and contacts go through the functions of prepare_contacts, integrate_velocities,
// integrate_positions, solve_contacts, apply_restitution and store_impulses, in the same order.
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

// Whether a work-item loads what its next contact's constraint holds before the groups meet: nobody else writes to it,
// and what was stored and what is loaded are waited for together.
#define HOLDS (WG > 1)

static inline void take_contacts(const solver *s, const source *from, const colour_part *part, uint pass,
                                 held_contact *held)
{
    const uint last = 2 * s->substeps;
    for (uint k = part->from; k < part->to; k += part->stride) {
        __global float *constraint = constraint_at(s->blocks, part, k);
        if (pass == 0)
            prepare_part(s->blocks, from, from->list, part, k);
        else if (pass > last)
            restore_speeds(constraint, s->bodies, s->fall, s->least_speed);
        else if (HOLDS)
            solve_pass(s, held, constraint);
        else
            solve_part(s, part, k);
        if (HOLDS && k + part->stride < part->to)
            hold_contact(held, constraint_at(s->blocks, part, k + part->stride));
        if (pass == last)
            store_part(s, from, part, k);
    }
}

static inline void hold_first(const solver *s, const colour_part *part, held_contact *held)
{
    if (part->from < part->to)
        hold_contact(held, constraint_at(s->blocks, part, part->from));
}

__kernel void solve_substeps(SOLVE_SUBSTEPS_ARGS)
{
    const source from = {SOLVE_SUBSTEPS_VALUES};
    const state to_accelerate = {SOLVE_SUBSTEPS_VALUES};
    const substep to_move = {SOLVE_SUBSTEPS_VALUES};
    solver s = {SOLVE_SUBSTEPS_VALUES};
    sweep parts = SWEEP;
    held_contact held;
    colour_part part;
    uint2 range;
    if (WAITS_FOR_HOST)
        return;
    const uint end = to_colour > 0 ? min(to_colour, spans[COLOUR_SPANS - 1].x) : 0;
#if HOLDS
    uint4 present = end > 0 ? spans[0] : (uint4)(0);
    part = own_part(0, present);
#endif
    for (uint pass = from_pass; pass < to_pass; ++pass) {
        s.soft = pass & 1u;
        if (pass > 0 && pass <= 2 * substeps) {
            BEGIN_BODIES(parts, N_AWAKE);
            while (next_bodies(&parts, N_AWAKE, &range)) {
                if (s.soft)
                    accelerate_bodies(&to_accelerate, range);
                else
                    move_bodies(&to_move, range);
            }
            END_PART(parts);
        }
        for (uint colour = 0; colour < end; ++colour) {
#if HOLDS
            const uint next = colour + 1 < end ? colour + 1 : 0;
            const uint4 coming = spans[next];
            const bool all_meet = next == 0 || !is_of_one(present.y) || !is_of_one(coming.y);
            take_contacts(&s, &from, &part, pass, &held);
            part = own_part(next, coming);
            hold_first(&s, &part, &held);
            if (all_meet)
                END_PART(parts);
            else
                barrier(CLK_GLOBAL_MEM_FENCE);
            present = coming;
#else
            BEGIN_PART(parts, colour);
            while (next_contacts(&parts, &part))
                take_contacts(&s, &from, &part, pass, &held);
            END_PART(parts);
#endif
        }
    }
}
