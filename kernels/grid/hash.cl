// SPDX-License-Identifier: MIT
// The cell of each object (equation 2), and with RANK its place among those
// that came to the cell before it, for the counting sort.
//
// Only keys from key_from to key_to are of interest, the others' objects belong
// to the other device; keys are written relative to key_from. Bad objects are
// reported by the device in whose keys, up to key_home_to, they would be: each
// object by one.
//
//   objects  [n]  poses or bounds, or with APART transforms; the first n_hashed
//            have their keys
//   sizes    [n + 1] (APART)
//   names    [n]  their ids, where they are not all (PACKED)
//   levels   [n_levels]
//   keys     [n]  NOWHERE for an object that is bad or elsewhere
//   counts   [key_to - key_from] zeroed before; objects a cell (RANK)
//   ranks    [n]  (RANK)
//@ if SUM_BLOCK > 0 then
//   sums     [...] zeroed before; objects in SUM_BLOCK cells each, for the scan of the counts
//@ end
//@ if STRAYS > 0 then
//   marks    [n / STRAYS]  the stamp where a block has a key from marked_from to marked_to
//@ end
//
//@ if OWN == 1 then
// Objects that are in about the order of cells need few atomics: the cells are divided between the
// work-items, each counts those of its objects that are in its own, and lists the others.
//
//   edges    [n / PER_ITEM, rounded up, + 1] the first own cell of each work-item, ascending
//   others   [n]  ids
//
//@ end
// BATCH keys are known before the first is counted, so that a CPU can ask for
// all their counts at once: they lie all over the grid. What is not in the grid
// is passed over without a branch: in a slab that is any half of the objects.
typedef struct {
    object_rows objects;
#if PACKED
    __global const uint *names;
#endif
    __constant const grid_level *levels;
    uint n_levels;
    uint n_cells;
    uint key_from, key_home_to, key_to;
//@ if STRAYS > 0 then
    uint marked_from, marked_to;
    uint stamp;
    volatile __global uint *marks;
//@ end
    volatile __global uint *counters;
} hashing;

static inline void report_bad(const hashing *h, mask bad, const uint ids[LANES], uint n)
{
    uint is_bad[LANES];
    spread(as_word(bad), is_bad);
    for (uint k = 0; k < LANES && k < n; ++k) {
        if (is_bad[k]) {
#if PACKED
            uint id = h->names[ids[k]];
#else
            uint id = ids[k];
#endif
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
    object o = object_at(h->objects, ids);
    word key = object_key(&o, h->levels, h->n_levels, h->n_cells);
    mask bad = object_is_bad(&o);
//@ if STRAYS > 0 then
    if (any_lane((key >= (word)(h->marked_from)) & (key < (word)(h->marked_to))))
        h->marks[ids[0] / STRAYS] = h->stamp; // whoever writes, writes the same
//@ end
    mask before = key < (word)(h->key_from);
    if (any_lane(bad))
        report_bad(h, bad & ~before & (key < (word)(h->key_home_to)), ids, last - id);
    mask elsewhere = bad | before | (key >= (word)(h->key_to));
    return select(key - h->key_from, (word)(NOWHERE), elsewhere);
}

//@ if SUM_BLOCK > 0 then
// Objects that came to one block of cells, one after the other: those in order change blocks rarely.
typedef struct {
    uint block, n;
} run;

static inline void end_run(run *r, volatile __global uint *sums)
{
    if (r->n > 0)
        atomic_add(sums + r->block, r->n);
    r->n = 0;
}

static inline void add_to_run(run *r, volatile __global uint *sums, uint key)
{
    if (key / SUM_BLOCK != r->block)
        end_run(r, sums);
    r->block = key / SUM_BLOCK;
    ++r->n;
}

//@ end
#if BATCH > 1

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

#endif

//@ if OWN == 1 then
static inline uint middle_of(uint a, uint b, uint c)
{
    return max(min(a, b), min(max(a, b), c));
}

// A work-item's own cells begin where its first objects are. A stray among them does not count, and
// cells are never two work-items' own, whatever the order. One work-item finds all edges.
__kernel void own_cells(OWN_CELLS_ARGS)
{
#if APART
    object_rows rows = {objects, sizes};
#else
    object_rows rows = objects;
#endif
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

//@ end
__kernel void hash(HASH_ARGS)
{
#if APART
    object_rows rows = {objects, sizes};
#else
    object_rows rows = objects;
#endif
    hashing h = {rows,
#if PACKED
                 names,
#endif
                 levels, n_levels, n_cells, key_from, key_home_to, key_to,
//@ if STRAYS > 0 then
                 marked_from, marked_to, stamp, marks,
//@ end
                 counters};
    uint first = n_hashed + get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
//@ if OWN == 1 then
    uint own_from = edges[first / PER_ITEM], n_own = edges[first / PER_ITEM + 1] - own_from;
//@ end
//@ if SUM_BLOCK > 0 then
    run counted = {0, 0};
//@ end
    for (uint from = first; from < last; from += BATCH) {
        uint found[BATCH];
        uint size = min(last - from, (uint)BATCH);
//@ if OWN == 0 then
#if RANK && BATCH > 1
        uint picked[BATCH + LANES], n_picked = 0;
#endif
//@ end
        for (uint i = 0; i < size; i += LANES) {
            word key = keys_of(&h, from + i, last);
            spread(key, found + i);
//@ if OWN == 0 then
#if RANK && BATCH > 1
            n_picked = pick(key, size - i, i, n_picked, picked);
            for (uint k = i; k < i + LANES; ++k)
                ask_for(counts + (found[k] == NOWHERE ? 0 : found[k]));
#endif
//@ end
        }
        for (uint k = 0; k < size; ++k)
            keys[from + k] = found[k];
//@ if OWN == 1 then
        uint elsewhere[BATCH], n_elsewhere = 0;
        for (uint k = 0; k < size; ++k) {
            uint key = found[k];
            if (key - own_from < n_own)
                found[k] = counts[key]++;
            else if (key != NOWHERE)
                elsewhere[n_elsewhere++] = from + k;
        }
        for (uint k = 0; k < size; ++k)
            ranks[from + k] = found[k];
        if (n_elsewhere > 0) {
            uint to = atomic_add(counters + COUNT_OTHERS, n_elsewhere);
            for (uint k = 0; k < n_elsewhere; ++k)
                others[to + k] = elsewhere[k];
        }
//@ else
#if RANK && BATCH > 1
//@ if SUM_BLOCK > 0 then
        for (uint k = 0; k < n_picked; ++k)
            add_to_run(&counted, sums, found[picked[k]]);
//@ end
        // Atomics wait for the stores before them, so the ranks are stored later.
        for (uint k = 0; k < n_picked; ++k)
            found[picked[k]] = atomic_inc(counts + found[picked[k]]);
        for (uint k = 0; k < size; ++k)
            ranks[from + k] = found[k];
#elif RANK
//@ if SUM_BLOCK > 0 then
        if (found[0] != NOWHERE)
            add_to_run(&counted, sums, found[0]);
//@ end
        if (found[0] != NOWHERE)
            ranks[from] = atomic_inc(counts + found[0]);
#endif
//@ end
    }
//@ if SUM_BLOCK > 0 then
    end_run(&counted, sums);
//@ end
}
