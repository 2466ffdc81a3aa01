// SPDX-License-Identifier: MIT
// Candidates to pairs (section 3): colliding ones by id, and those that float
// cannot decide to a list of their own for the host.
//
//   boxes      SORTED 1: [n][3] in cell order, centre.w the id
//   objects    SORTED 0: as they came, read by id
//   candidates [*count] pairs of places (SORTED 1) or ids (SORTED 0)
//   pairs      [pair_capacity] ids
//   undecided  [undecided_capacity] ids
__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
narrow(NARROW_ARGS)
{
    __local uint2 collected[WG * PER_ITEM];
    __local uint used;
    __local uint base;
    uint n = counters[COUNT_CANDIDATES + 1] ? candidate_capacity : min(counters[COUNT_CANDIDATES], candidate_capacity);
    uint tile = WG * PER_ITEM;
    for (uint from = get_group_id(0) * tile; from < n; from += get_num_groups(0) * tile) {
        if (get_local_id(0) == 0)
            used = 0;
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint k = from + get_local_id(0); k < min(from + tile, n); k += WG) {
            uint2 candidate = candidates[k];
            uint id_a, id_b;
            box a = box_at(STORED, candidate.x, &id_a);
            box b = box_at(STORED, candidate.y, &id_b);
            order_boxes(&a, &b);
            decided v = answer(&a, &b);
            if (v.colliding) {
                collected[atomic_inc(&used)] = ordered(id_a, id_b);
            } else if (!v.separated) {
                uint to = reserve(counters + COUNT_UNDECIDED, 1);
                if (to < undecided_capacity)
                    undecided[to] = ordered(id_a, id_b);
            }
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        if (get_local_id(0) == 0)
            base = reserve(counters + COUNT_PAIRS, used);
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint k = get_local_id(0); k < used; k += WG)
            if (base + k < pair_capacity)
                pairs[base + k] = collected[k];
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}
