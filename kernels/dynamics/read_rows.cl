// SPDX-License-Identifier: MIT
// What a host reads of a motion's state: rows of some objects one behind the other, and
// which rows have changed since they were read last. Rows are words, whatever they hold.
//
//   rows, last_rows [n][row_words]
//   ids             [n_ids] places of rows; NO_PLACE: a row of 0
//   gathered        [n_ids][row_words]
//   changed         [(n + 31) / 32] a bit for each row
__kernel void gather_rows(GATHER_ROWS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_ids);
    for (uint i = first; i < last; ++i)
        for (uint k = 0; k < row_words; ++k)
            gathered[(size_t)i * row_words + k] = ids[i] == NO_PLACE ? 0 : rows[(size_t)ids[i] * row_words + k];
}

__kernel void changed_rows(CHANGED_ROWS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, (n + 31) / 32);
    for (uint w = first; w < last; ++w) {
        uint word = changed[w];
        for (uint i = 32 * w; i < min(32 * w + 32, n); ++i) {
            for (size_t at = (size_t)i * row_words; at < ((size_t)i + 1) * row_words; ++at) {
                word |= rows[at] != last_rows[at] ? 1u << (i & 31u) : 0u;
                last_rows[at] = rows[at];
            }
        }
        changed[w] = word;
    }
}
