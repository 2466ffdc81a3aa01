// SPDX-License-Identifier: MIT
// Parts of rows by body that travel: of some bodies one behind the other. Rows are words, whatever
// they hold.
//
//   rows      [n][row_words]
//   row_parts word at which the first part begins, and how many words are taken; the same of the second
//   of_four   words that are taken of every four of the first part; the second is taken whole
//   row_ids   places, each once: [n_ids] from first_id on
//   gathered  [n_ids][words of both parts]
static inline size_t place_of_word(uint id, uint row_words, uint4 parts, uint of_four, uint k)
{
    uint word = k < parts.y ? parts.x + k / of_four * 4 + k % of_four : parts.z + k - parts.y;
    return (size_t)id * row_words + word;
}

__kernel void pack_rows(PACK_ROWS_ARGS)
{
    uint4 parts = as_uint4(row_parts);
    uint first = get_global_id(0) * PER_ITEM, words = parts.y + parts.w;
    uint last = min(first + PER_ITEM, n_ids);
    for (uint i = first; i < last; ++i)
        for (uint k = 0; k < words; ++k)
            gathered[(size_t)i * words + k] = rows[place_of_word(row_ids[first_id + i], row_words, parts, of_four, k)];
}

__kernel void unpack_rows(UNPACK_ROWS_ARGS)
{
    uint4 parts = as_uint4(row_parts);
    uint first = get_global_id(0) * PER_ITEM, words = parts.y + parts.w;
    uint last = min(first + PER_ITEM, n_ids);
    for (uint i = first; i < last; ++i)
        for (uint k = 0; k < words; ++k)
            rows[place_of_word(row_ids[first_id + i], row_words, parts, of_four, k)] = gathered[(size_t)i * words + k];
}
