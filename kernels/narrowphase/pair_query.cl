// SPDX-License-Identifier: MIT
// Answers about pairs that the caller brings, by the text that tests a step's
// candidates: bounds first, then what ACCURACY asks for.
//
// Float may see (a, b) other than (b, a). The lower box is taken for the first,
// so that both ways round give the same answer, bit for bit.
//
//   poses    [2 n][10] pair i is rows 2 i and 2 i + 1
//   answers  [n, rounded up to LANES]
#define SEPARATED 0
#define COLLIDING 1
#define UNDECIDED 2 // left to the host
#define NO_BOX 3    // one of the two is no box

static inline mask bounds_apart(const object *a, const object *b)
{
    bounds of_a = object_bounds(a), of_b = object_bounds(b);
    mask apart = (mask)(0);
#pragma unroll
    for (int k = 0; k < DIMS; ++k)
        apart |= (of_a.lower[k] > of_b.upper[k]) | (of_b.lower[k] > of_a.upper[k]);
    return apart;
}

// By x, where that is equal by y, then by z.
static inline mask is_above(const box *a, const box *b)
{
    mask above = (mask)(0);
#pragma unroll
    for (int k = DIMS - 1; k >= 0; --k)
        above = (a->centre[k] > b->centre[k]) | ((a->centre[k] == b->centre[k]) & above);
    return above;
}

static inline word test(const object *a, const object *b)
{
    box box_a = box_of(a), box_b = box_of(b);
    swap_boxes(&box_a, &box_b, is_above(&box_a, &box_b));
    verdicts v = verdict(&box_a, &box_b);
    word found = select((word)(UNDECIDED), (word)(COLLIDING), v.colliding);
    found = select(found, (word)(SEPARATED), v.separated | bounds_apart(a, b));
    return select(found, (word)(NO_BOX), object_is_bad(a) | object_is_bad(b));
}

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
        store_bytes(test(&a, &b), answers + from);
    }
}
