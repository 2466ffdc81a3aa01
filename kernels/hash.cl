// SPDX-License-Identifier: MIT
// The cell of each object (equation 2), and with RANK its place among those
// that came to the cell before it, for the counting sort.
//
// Only keys from key_from to key_to are of interest, the others' objects belong
// to the other device; keys are written relative to key_from.
//
//   objects  [n]  poses or bounds
//   levels   [n_levels]
//   keys     [n]  NOWHERE for an object that is bad or elsewhere
//   counts   [key_to - key_from] zeroed before; objects a cell (RANK)
//   ranks    [n]  (RANK)
//
// BATCH keys are known before the first is counted, so that a CPU can ask for
// all their counts at once: they lie all over the grid.
static inline void report_bad(mask bad, uint id, uint last, volatile __global uint *counters)
{
    uint is_bad[LANES];
    spread(as_word(bad), is_bad);
    for (uint k = 0; k < LANES && id + k < last; ++k) {
        if (is_bad[k]) {
            atomic_inc(counters + COUNT_BAD);
            atomic_max(counters + FIRST_BAD, ~(id + k));
        }
    }
}

// The keys of objects id .. id + LANES - 1; past the end the last one's again.
static inline word keys_of(__global const float *objects, uint id, uint last, __constant const grid_level *levels,
                           uint n_levels, uint n_cells, uint key_from, uint key_to, volatile __global uint *counters)
{
    uint ids[LANES];
    for (uint k = 0; k < LANES; ++k)
        ids[k] = min(id + k, last - 1);
    object o = object_at(objects, ids);
    word key = object_key(&o, levels, n_levels, n_cells);
    mask bad = object_is_bad(&o);
    if (any_lane(bad))
        report_bad(bad, id, last, counters);
    mask elsewhere = bad | (key < (word)(key_from)) | (key >= (word)(key_to));
    return select(key - key_from, (word)(NOWHERE), elsewhere);
}

__kernel void hash(__global const float *restrict objects, uint n, __constant const grid_level *levels, uint n_levels,
                   uint n_cells, uint key_from, uint key_to, __global uint *restrict keys,
#if RANK
                   volatile __global uint *restrict counts, __global uint *restrict ranks,
#endif
                   volatile __global uint *restrict counters)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint from = first; from < last; from += BATCH) {
        uint found[BATCH];
        uint size = min(last - from, (uint)BATCH);
        for (uint i = 0; i < size; i += LANES) {
            word key = keys_of(objects, from + i, last, levels, n_levels, n_cells, key_from, key_to, counters);
            spread(key, found + i);
#if RANK && BATCH > 1
            for (uint k = i; k < i + LANES; ++k)
                ask_for(counts + (found[k] == NOWHERE ? 0 : found[k]));
#endif
        }
        for (uint k = 0; k < size; ++k) {
            keys[from + k] = found[k];
#if RANK
            if (found[k] != NOWHERE)
                ranks[from + k] = atomic_inc(counts + found[k]);
#endif
        }
    }
}
