// SPDX-License-Identifier: MIT
// All rounds of colouring (graph_colour.cl) in one launch, of groups that all run at once and meet (meet.clh).

__kernel void colour_rounds(COLOUR_ROUNDS_ARGS)
{
    const colouring c = {COLOUR_ROUNDS_VALUES};
    const uint n_here = N_AWAKE, first = get_global_id(0), all = get_global_size(0);
    for (uint turn = 1; flags[FLAG_UNCOLOURED] > 0; ++turn) {
        for (uint k = first; k < n_here; k += all)
            choose_contacts(&c, k, k + 1);
        meet(team);
        for (uint k = first; k < n_here; k += all)
            take_contacts(&c, turn, k, k + 1);
        meet(team);
    }
}
