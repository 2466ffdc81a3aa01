// SPDX-License-Identifier: MIT
// Where each cell begins among the sorted keys. Keys from key_end on are of
// objects that are not in the grid.
//
// cell_start is the paper's (section 2.2): key_starts [key_end] set to NONE
// before, and only cells that hold something are written. row_start writes all
// key_end + 1, an empty cell beginning where the next one does, so that cells
// in a row are one range.
__kernel void cell_start(CELL_START_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_keys);
    for (uint i = first; i < last; ++i)
        if (keys[i] < key_end && (i == 0 || keys[i] != keys[i - 1]))
            key_starts[keys[i]] = i;
}

// One work-item more than there are keys: the last fills to the end.
__kernel void row_start(ROW_START_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_keys + 1);
    for (uint i = first; i < last; ++i) {
        uint from = i == 0 ? 0 : min(keys[i - 1], key_end) + 1;
        uint to = i == n_keys ? key_end : min(keys[i], key_end);
        for (uint cell = from; cell <= to; ++cell)
            key_starts[cell] = i;
    }
}
