// SPDX-License-Identifier: MIT
// Substeps in one launch: as launches they would wait for each other longer than they take.
//
// Invariant: bodies and contacts go through the functions of integrate_velocities, integrate_positions and
// solve_contacts, in the same order.
//
//   spans       as colour_parts.clh has them
//   n_substeps  each has two passes over the bodies and then the colours, as solve_contacts.cl has them
//   soft        of the pass, whatever the host says

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

__kernel void solve_substeps(SOLVE_SUBSTEPS_ARGS)
{
    const state to_accelerate = {SOLVE_SUBSTEPS_VALUES};
    const substep to_move = {SOLVE_SUBSTEPS_VALUES};
    solver s = {SOLVE_SUBSTEPS_VALUES};
    sweep parts = SWEEP;
    colour_part part;
    uint2 range;
    for (uint pass = 0; pass < 2 * n_substeps; ++pass) {
        s.soft = ~pass & 1u;
        BEGIN_BODIES(parts, N_AWAKE);
        while (next_bodies(&parts, N_AWAKE, &range)) {
            if (s.soft)
                accelerate_bodies(&to_accelerate, range);
            else
                move_bodies(&to_move, range);
        }
        END_PART(parts);
        for (uint colour = from_colour; colour < to_colour; ++colour) {
            BEGIN_PART(parts, colour);
            while (next_contacts(&parts, &part))
                for (uint k = part.from; k < part.to; k += part.stride)
                    solve_part(&s, &part, k);
            END_PART(parts);
        }
    }
}
