// SPDX-License-Identifier: MIT
// Solves the contacts of one colour after the other by sequential impulses.
//
// Invariant: contacts of a colour share no body that moves (constraint.clh), so their order does not
// matter and the result is the same on every device.
//
//   a substep:   integrate velocities        (bodies.cl)
//                solve, soft = 1             springs push overlapping points apart
//                integrate positions
//                solve, soft = 0             relaxes: takes back the velocity that springs added
//   a step ends: apply_restitution
//
//   blocks  constraints (constraint.clh)
//   each    contacts of a colour that a work-item takes

__kernel void solve_contacts(SOLVE_CONTACTS_ARGS)
{
    const solver s = {SOLVE_CONTACTS_VALUES};
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to; k += part.stride)
                solve_part(&s, &part, k);
        END_COLOUR(parts);
    }
}

__kernel void apply_restitution(APPLY_RESTITUTION_ARGS)
{
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to; k += part.stride)
                restore_speeds(constraint_at(blocks, &part, k), bodies, fall, least_speed);
        END_COLOUR(parts);
    }
}
