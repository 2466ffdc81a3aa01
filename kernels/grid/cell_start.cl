// SPDX-License-Identifier: MIT
// Where each cell begins among the sorted keys. Keys from n_cells on are of
// objects that are not in the grid.
//
// cell_start is the paper's (section 2.2): starts [n_cells] set to NONE
// before, and only cells that hold something are written. row_start writes all
// n_cells + 1, an empty cell beginning where the next one does, so that cells
// in a row are one range.
__kernel void cell_start(__global const uint *restrict keys, uint n, uint n_cells, __global uint *restrict starts)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint i = first; i < last; ++i)
        if (keys[i] < n_cells && (i == 0 || keys[i] != keys[i - 1]))
            starts[keys[i]] = i;
}

// One work-item more than there are keys: the last fills to the end.
__kernel void row_start(__global const uint *restrict keys, uint n, uint n_cells,
                        __global uint *restrict starts)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n + 1);
    for (uint i = first; i < last; ++i) {
        uint from = i == 0 ? 0 : min(keys[i - 1], n_cells) + 1;
        uint to = i == n ? n_cells : min(keys[i], n_cells);
        for (uint cell = from; cell <= to; ++cell)
            starts[cell] = i;
    }
}
