// SPDX-License-Identifier: MIT
// Answers about pairs that the caller brings.
//
//   poses    [2 n][10] pair i is rows 2 i and 2 i + 1
//   answers  [n, rounded up to LANES]
#define NO_BOX 3 // one of the two is no box

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
pair_query(PAIR_QUERY_ARGS)
{
    uint begin = get_global_id(0) * PER_ITEM;
    for (uint from = begin; from < min(begin + PER_ITEM, n); from += LANES) {
        uint first[LANES], second[LANES];
        for (uint k = 0; k < LANES; ++k) {
            uint pair = min(from + k, n - 1); // no row is read past the last
            first[k] = 2 * pair;
            second[k] = 2 * pair + 1;
        }
        object a = object_at(poses, first), b = object_at(poses, second);
        word found = answer_of(&a, &b);
        store_bytes(select(found, (word)(NO_BOX), object_is_bad(&a) | object_is_bad(&b)), answers + from);
    }
}
