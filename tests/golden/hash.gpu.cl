// hash.DIMS3.SHAPE0.ROTATED1.GRID0.LEVELS0.RANK1.PACKED0.LANES1.BATCH1.WG256.PER_ITEM1
#define DIMS 3
#define SHAPE 0
#define ROTATED 1
#define GRID 0
#define LEVELS 0
#define RANK 1
#define PACKED 0
#define LANES 1
#define BATCH 1
#define CELLS_X 0
#define CELLS_Y 0
#define CELLS_Z 0
#define WG 256
#define PER_ITEM 1
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/object.clh"
#line 1 "kernels/grid.clh"
#line 1 "kernels/hash.cl"
// SPDX-License-Identifier: MIT
// The cell of each object (equation 2), and with RANK its place among those
// that came to the cell before it, for the counting sort.
//
// Only keys from key_from to key_to are of interest, the others' objects belong
// to the other device; keys are written relative to key_from.
//
//   objects  [n]  poses or bounds
//   names    [n]  their ids; the bad ones among the first n_homes are this
//                 device's to report (PACKED)
//   levels   [n_levels]
//   keys     [n]  NOWHERE for an object that is bad or elsewhere
//   counts   [key_to - key_from] zeroed before; objects a cell (RANK)
//   ranks    [n]  (RANK)
//
// BATCH keys are known before the first is counted, so that a CPU can ask for
// all their counts at once: they lie all over the grid.
typedef struct {
    volatile __global uint *counters;
#if PACKED
    __global const uint *names;
    uint n_homes;
#endif
} reporter;

static inline void report_bad(mask bad, uint first, uint last, const reporter *to)
{
    uint is_bad[LANES];
    spread(as_word(bad), is_bad);
#if PACKED
    last = min(last, to->n_homes);
#endif
    for (uint k = 0; k < LANES && first + k < last; ++k) {
        if (is_bad[k]) {
#if PACKED
            uint id = to->names[first + k];
#else
            uint id = first + k;
#endif
            atomic_inc(to->counters + COUNT_BAD);
            atomic_max(to->counters + FIRST_BAD, ~id);
        }
    }
}

// The keys of objects id .. id + LANES - 1; past the end the last one's again.
static inline word keys_of(__global const float *objects, uint id, uint last, __constant const grid_level *levels,
                           uint n_levels, uint n_cells, uint key_from, uint key_to, const reporter *to)
{
    uint ids[LANES];
    for (uint k = 0; k < LANES; ++k)
        ids[k] = min(id + k, last - 1);
    object o = object_at(objects, ids);
    word key = object_key(&o, levels, n_levels, n_cells);
    mask bad = object_is_bad(&o);
    if (any_lane(bad))
        report_bad(bad, id, last, to);
    mask elsewhere = bad | (key < (word)(key_from)) | (key >= (word)(key_to));
    return select(key - key_from, (word)(NOWHERE), elsewhere);
}

__kernel void hash(__global const float *restrict objects, uint n,
#if PACKED
                   __global const uint *restrict names, uint n_homes,
#endif
                   __constant const grid_level *levels, uint n_levels, uint n_cells, uint key_from,
                   uint key_to, __global uint *restrict keys,
#if RANK
                   volatile __global uint *restrict counts, __global uint *restrict ranks,
#endif
                   volatile __global uint *restrict counters)
{
#if PACKED
    reporter to = {counters, names, n_homes};
#else
    reporter to = {counters};
#endif
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint from = first; from < last; from += BATCH) {
        uint found[BATCH];
        uint size = min(last - from, (uint)BATCH);
        for (uint i = 0; i < size; i += LANES) {
            word key = keys_of(objects, from + i, last, levels, n_levels, n_cells, key_from, key_to, &to);
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
