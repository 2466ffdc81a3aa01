// SPDX-License-Identifier: MIT
// The cell of each object (equation 2), and with RANK its rank among those that came to the cell
// before it, for the counting sort.
//
// Invariant: of two devices that each have a range of keys, each bad object is reported by one: the one
// in whose range, key_from up to key_home_to, its key would be. Only keys up to key_to are of interest;
// they are written relative to key_from.
//
//   a batch:  objects --> keys of BATCH objects --+-- OWN:  own cells counted, other objects listed
//                                                 +-- else: counted with atomics
//
// BATCH keys are known before the first is counted, so that a CPU can ask for all their counts at
// once: they lie all over the grid. An object that is not in the grid is passed over without a branch:
// in a slab that is any half of the objects.
//
// Objects that are in about the order of cells need few atomics (OWN): the cells are divided between
// the work-items, each counts those of its objects that are in its own cells, and lists the others.
//
//   objects  [n]  poses or bounds, or with APART transforms; the first n_hashed
//            have their keys
//   sizes    [n + 1] (APART)
//   names    [n]  their ids, if they are not all objects (PACKED)
//   levels   [n_levels]
//   keys     [n]  NOWHERE for an object that is bad or elsewhere
//   counts   [key_to - key_from] zeroed before; objects a cell (RANK)
//   ranks    [n]  (RANK)
//   marks    [n / STRAYS]  the stamp if a block has a key from marked_from to marked_to (STRAYS)
//   edges    [n / PER_ITEM, rounded up, + 1] the first own cell of each work-item, ascending (OWN)
//   others   [n]  ids of objects in cells of other work-items (OWN)
#ifndef OWN
#define OWN 0
#endif
#ifndef STRAYS
#define STRAYS 0
#endif

typedef struct {
    ARG_FIELDS
} hashing;

// ------------------------------------------------------------ keys

static inline void report_bad(const hashing *h, mask bad, const uint ids[LANES], uint n)
{
    uint is_bad[LANES];
    spread(as_word(bad), is_bad);
    for (uint k = 0; k < LANES && k < n; ++k) {
        if (is_bad[k]) {
            uint id = PACKED ? h->names[ids[k]] : ids[k];
            atomic_inc(h->counters + COUNT_BAD);
            atomic_max(h->counters + FIRST_BAD, ~id);
        }
    }
}

// The keys of objects id .. id + LANES - 1; past the end the last one's again.
static inline word keys_of(const hashing *h, uint id, uint last)
{
    uint ids[LANES];
    for (uint k = 0; k < LANES; ++k)
        ids[k] = min(id + k, last - 1);
    object_rows rows = OBJECT_ROWS(h->);
    object o = object_at(rows, ids);
    word key = object_key(&o, h->levels, h->n_levels, h->n_cells);
    mask bad = object_is_bad(&o);
#if STRAYS
    if (any_lane((key >= (word)(h->marked_from)) & (key < (word)(h->marked_to))))
        h->marks[ids[0] / STRAYS] = h->stamp; // whoever writes, writes the same
#endif
    mask before = key < (word)(h->key_from);
    if (any_lane(bad))
        report_bad(h, bad & ~before & (key < (word)(h->key_home_to)), ids, last - id);
    mask elsewhere = bad | before | (key >= (word)(h->key_to));
    return select(key - h->key_from, (word)(NOWHERE), elsewhere);
}

// Adds those of the first n keys from place on that are in this grid.
static inline uint pick(word key, uint n, uint place, uint n_picked, uint picked[BATCH + LANES])
{
#if LANES == 1
    picked[n_picked] = place;
    return n_picked + (key != NOWHERE);
#else
    ulong here = lane_bits(key != (word)(NOWHERE)) & first_lanes(n);
    ulong before = here * 0x0101010101010100ul; // byte k: how many lanes before k
#pragma unroll
    for (uint k = 0; k < LANES; ++k)
        picked[n_picked + (uint)(before >> 8 * k & 0xff)] = place + k;
    return n_picked + (uint)(here * 0x0101010101010101ul >> 56);
#endif
}

// Finds the keys of a batch, and in `picked` its places that are to be ranked. Returns their number.
static inline uint find_keys(const hashing *h, uint from, uint size, uint last, uint found[BATCH],
                             uint picked[BATCH + LANES])
{
    uint n_picked = 0;
    for (uint i = 0; i < size; i += LANES) {
        word key = keys_of(h, from + i, last);
        spread(key, found + i);
        if (OWN || !RANK || BATCH == 1)
            continue;
        n_picked = pick(key, size - i, i, n_picked, picked);
        for (uint k = i; k < i + LANES; ++k)
            ask_for(h->counts + (found[k] == NOWHERE ? 0 : found[k]));
    }
    return n_picked;
}

// ------------------------------------------------------------ ranks

// Atomics wait for the stores before them, so the ranks are stored later.
static inline void rank_batch(const hashing *h, uint from, uint size, uint found[BATCH],
                              const uint picked[BATCH + LANES], uint n_picked)
{
    for (uint k = 0; k < n_picked; ++k)
        found[picked[k]] = atomic_inc(h->counts + found[picked[k]]);
    for (uint k = 0; k < size; ++k)
        h->ranks[from + k] = found[k];
}

static inline void rank_one(const hashing *h, uint id, uint key)
{
    if (key != NOWHERE)
        h->ranks[id] = atomic_inc(h->counts + key);
}

// Ranks objects in the work-item's own cells, n_own from own_from on, and lists the others. The counts
// of own cells are written by this work-item alone.
static inline void rank_own(const hashing *h, __global uint *others, uint own_from, uint n_own, uint from, uint size,
                            uint found[BATCH])
{
    uint elsewhere[BATCH], n_elsewhere = 0;
    for (uint k = 0; k < size; ++k) {
        uint key = found[k];
        if (key - own_from < n_own)
            found[k] = h->counts[key]++;
        else if (key != NOWHERE)
            elsewhere[n_elsewhere++] = from + k;
    }
    for (uint k = 0; k < size; ++k)
        h->ranks[from + k] = found[k];
    if (n_elsewhere == 0)
        return;
    uint to = atomic_add(h->counters + COUNT_OTHERS, n_elsewhere);
    for (uint k = 0; k < n_elsewhere; ++k)
        others[to + k] = elsewhere[k];
}

__kernel void hash(HASH_ARGS)
{
    const hashing h = {HASH_VALUES};
    uint first = n_hashed + get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
#if OWN
    uint own_from = edges[first / PER_ITEM], n_own = edges[first / PER_ITEM + 1] - own_from;
#endif
    for (uint from = first; from < last; from += BATCH) {
        uint found[BATCH], picked[BATCH + LANES];
        uint size = min(last - from, (uint)BATCH);
        uint n_picked = find_keys(&h, from, size, last, found, picked);
        for (uint k = 0; k < size; ++k)
            keys[from + k] = found[k];
#if OWN
        rank_own(&h, others, own_from, n_own, from, size, found);
#else
        if (RANK && BATCH > 1)
            rank_batch(&h, from, size, found, picked, n_picked);
        else if (RANK)
            rank_one(&h, from, found[0]);
#endif
    }
}

// ------------------------------------------------------------ own cells

#if OWN

static inline uint middle_of(uint a, uint b, uint c)
{
    return max(min(a, b), min(max(a, b), c));
}

// A work-item's own cells begin where its first objects are. A stray among them does not count, and
// cells are never two work-items' own, whatever the order. One work-item finds all edges.
__kernel void own_cells(OWN_CELLS_ARGS)
{
    object_rows rows = OBJECT_ROWS();
    uint n_items = (n - 1) / PER_ITEM + 1;
    uint edge = 0;
    edges[0] = 0;
    for (uint item = 1; item < n_items; ++item) {
        uint ids[LANES], at[LANES];
        for (uint k = 0; k < LANES; ++k)
            ids[k] = min(item * PER_ITEM + k, n - 1);
        object o = object_at(rows, ids);
        spread(object_key(&o, levels, n_levels, n_cells), at);
        uint key = middle_of(at[0], at[LANES / 2], at[LANES - 1]);
        edge = max(edge, key < key_from ? 0 : key - key_from);
        edges[item] = edge;
    }
    edges[n_items] = NOWHERE;
}

// Counts the others, once every work-item has counted its own.
__kernel void count_others(COUNT_OTHERS_ARGS)
{
    uint n_others = counters[COUNT_OTHERS], n_items = (uint)get_global_size(0);
    uint each = n_others / n_items + 1;
    uint from = get_global_id(0) * each;
    for (uint i = from; i < min(from + each, n_others); ++i)
        ranks[others[i]] = atomic_inc(counts + keys[others[i]]);
}

#endif
