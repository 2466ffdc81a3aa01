// SPDX-License-Identifier: MIT
// The paper's search (section 2.3): each work-item takes one object and walks
// the 27 (9 in 2D) cells around it through the cell start array, reads bounds
// through the sorted ids, and takes one atomic a pair.
//
//   keys   [n]       sorted cells
//   ids    [n]       objects in that order
//   starts [n_own_cells] first of each cell from key_from, or NONE
//   bounds_by_id [n][2] lower and upper corner
//   cells            along each axis; not read where CELLS_X compiles them in
//   found  [found_capacity] pairs of ids; the answer itself with IDS
#define NONE 0xffffffffu

static inline bool bounds_overlap(float4 lower_a, float4 upper_a, float4 lower_b, float4 upper_b)
{
    bool overlap = lower_a.x <= upper_b.x && lower_b.x <= upper_a.x && lower_a.y <= upper_b.y &&
                   lower_b.y <= upper_a.y;
#if DIMS == 3
    overlap = overlap && lower_a.z <= upper_b.z && lower_b.z <= upper_a.z;
#endif
    return overlap;
}

// The pairs of place i with those that come after it.
static inline void search_cells(__global const uint *keys, __global const uint *ids, __global const uint *starts,
                                __global const float4 *bounds_by_id, uint n, uint i, int4 cells, uint key_from,
                                uint n_own_cells, __global uint2 *found, uint capacity,
                                volatile __global uint *counter)
{
    uint id = ids[i];
    float4 lower = bounds_by_id[2 * (size_t)id];
    float4 upper = bounds_by_id[2 * (size_t)id + 1];
    uint key = keys[i] + key_from;
    uint row = key / (uint)cells.x;
    int x = (int)(key % (uint)cells.x);
    int y = (int)(row % (uint)cells.y);
    int z = (int)(row / (uint)cells.y);
    for (int cz = max(z - 1, 0); cz <= min(z + 1, cells.z - 1); ++cz) {
        for (int cy = max(y - 1, 0); cy <= min(y + 1, cells.y - 1); ++cy) {
            for (int cx = max(x - 1, 0); cx <= min(x + 1, cells.x - 1); ++cx) {
                uint cell = ((uint)cz * (uint)cells.y + (uint)cy) * (uint)cells.x + (uint)cx - key_from;
                if (cell >= n_own_cells) // the other device's, and found from there
                    continue;
                uint start = starts[cell];
                if (start == NONE)
                    continue;
                for (uint j = start; j < n && keys[j] == cell; ++j) {
                    uint other = ids[j];
                    bool overlap = bounds_overlap(lower, upper, bounds_by_id[2 * (size_t)other],
                                                  bounds_by_id[2 * (size_t)other + 1]);
                    if (overlap && i < j) { // the other side finds it too
                        uint slot = reserve(counter, 1);
                        if (slot < capacity)
                            found[slot] = ordered(id, other);
                    }
                }
            }
        }
    }
}

// Returns the begin of the cell of place i: parts that each sorted for themselves agree
// on it, though not on the order inside a cell.
static inline uint cell_begin(__global const uint *keys, __global const uint *starts, uint i, uint n,
                              uint n_own_cells)
{
    return i < n && keys[i] < n_own_cells ? starts[keys[i]] : i;
}

__kernel void pair_search_paper(PAIR_SEARCH_PAPER_ARGS)
{
#if CELLS_X
    cells = (int4)(CELLS_X, CELLS_Y, CELLS_Z, 0);
#endif
    volatile __global uint *counter = counters + (IDS ? COUNT_PAIRS : COUNT_CANDIDATES);
    uint end = min(cell_begin(keys, starts, last, n, n_own_cells), n);
    uint i = cell_begin(keys, starts, first, n, n_own_cells) + get_global_id(0);
    for (; i < end && keys[i] < n_home_cells; i += get_global_size(0))
        search_cells(keys, ids, starts, bounds_by_id, n, i, cells, key_from, n_own_cells, found, found_capacity, counter);
}
