// SPDX-License-Identifier: MIT
// Positions and rotations of the bodies after a substep.
//
//   bodies [n + FIXED][BODY]  the last are the walls and the ground

__kernel void integrate_positions(INTEGRATE_POSITIONS_ARGS)
{
    const substep s = {INTEGRATE_POSITIONS_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
#if ANGULAR_VELOCITY
    for (uint k = first; k < last; k += LANES) {
        uint ids[LANES];
        word wanted = list_lanes(&s, k, last, ids);
        integrate_lanes(&s, ids, wanted);
    }
#else
    for (uint k = first; k < last; ++k)
        move_body(&s, AWAKE_AT(k));
#endif
}
