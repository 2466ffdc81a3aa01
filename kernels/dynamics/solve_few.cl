// SPDX-License-Identifier: MIT
// All substeps of a step in which few bodies are awake, by one work-group: as launches they would wait for each
// other longer than they take.
//
// Invariant: bodies and contacts go through the functions of integrate_velocities, integrate_positions and
// solve_contacts, in the same order.
//
//   spans     as colour_parts.clh has them; no colour has more than the group takes at once
//   substeps  each has two passes over the colours, as solve_contacts.cl has them
//   soft      of the pass, whatever the host says
#if WG > 1
#define END_PASS barrier(CLK_GLOBAL_MEM_FENCE)
#else
#define END_PASS
#endif

static inline void move_all(const substep *s, uint n_here)
{
#if ANGULAR_VELOCITY
    for (uint k = get_local_id(0) * LANES; k < n_here; k += WG * LANES) {
        uint ids[LANES];
        word wanted = list_lanes(s, k, n_here, ids);
        integrate_lanes(s, ids, wanted);
    }
#else
    for (uint k = get_local_id(0); k < n_here; k += WG)
        move_body(s, AWAKE_OF(s, k));
#endif
}

static inline void solve_colours(const solver *s)
{
    for (uint colour = 0; colour < s->to_colour; ++colour) {
        const colour_part part = part_from(colour, s->spans[colour], get_local_id(0) * PER_ITEM, PER_ITEM);
        for (uint k = part.from; k < part.to; k += part.stride)
            solve_part(s, &part, k);
        END_PASS;
    }
}

__kernel void solve_few(SOLVE_FEW_ARGS)
{
    const state to_accelerate = {SOLVE_FEW_VALUES};
    const substep to_move = {SOLVE_FEW_VALUES};
    solver s = {SOLVE_FEW_VALUES};
    const uint n_here = N_AWAKE;
    for (uint pass = 0; pass < 2 * substeps; ++pass) {
        s.soft = ~pass & 1u;
        if (s.soft)
            for (uint k = get_local_id(0); k < n_here; k += WG)
                integrate_velocity(&to_accelerate, bodies, AWAKE_AT(k));
        else
            move_all(&to_move, n_here);
        END_PASS;
        solve_colours(&s);
    }
}
