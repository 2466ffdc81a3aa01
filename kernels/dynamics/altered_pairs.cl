// SPDX-License-Identifier: MIT
// Pairs of fat AABBs after commands altered some of the bodies: the altered ones go into a hash
// table, by the cells that their boxes overlap, and each body that meets the box around all of these looks into
// the cells of its own.
// Pairs of bodies that were left alone are those of the rows.
//
//   altered    [n_altered] ids, each once
//   boxes      [n][6]  of altered bodies the new ones, of the others those that rows are made of
//   is_altered [n]
//   heads      [n_heads]  the first entry of each list, and 1; 0: none
//   entries    a cell, and w: the body there
//   nexts      of each entry, as heads
//   wide       altered bodies of too many cells for the table
typedef struct {
    float3 lower, upper;
} aabb;

static inline aabb aabb_at(__global const float *boxes, uint id)
{
    aabb box;
    box.lower = vload3(2 * (size_t)id, boxes);
    box.upper = vload3(2 * (size_t)id + 1, boxes);
    return box;
}

// That of what is removed or disabled ends before it begins.
static inline bool is_there(const aabb *box)
{
    return box->lower.x <= box->upper.x;
}

static inline bool do_overlap(const aabb *a, const aabb *b)
{
    return all(a->lower <= b->upper) && all(b->lower <= a->upper);
}

// ------------------------------------------------------------ the box around the table's bodies

static inline void put_around(volatile __global uint *counts, const aabb *box)
{
    raise_words(counts + ALTERED_AROUND, box->upper);
    raise_words(counts + ALTERED_AROUND + 3, -box->lower);
}

// If the table is empty words are 0, which stand for no numbers: nothing overlaps that box.
static inline aabb around_table(volatile __global const uint *counts)
{
    volatile __global const uint *words = counts + ALTERED_AROUND;
    return (aabb){-(float3)(number_of(words[3]), number_of(words[4]), number_of(words[5])),
                  (float3)(number_of(words[0]), number_of(words[1]), number_of(words[2]))};
}

// ------------------------------------------------------------ cells

// Of a body: its cells, from the lower corner's up to the upper one's.
typedef struct {
    int3 from, to;
} cell_range;

static inline int3 cell_at(float3 corner, float per_edge)
{
    return convert_int3(clamp(floor(corner * per_edge), (float3)(-0x1p30f), (float3)(0x1p30f)));
}

static inline cell_range cells_of(const aabb *box, float per_edge)
{
    cell_range cells;
    cells.from = cell_at(box->lower, per_edge);
    cells.to = cell_at(box->upper, per_edge);
    return cells;
}

static inline bool are_many(const cell_range *cells)
{
    float3 size = convert_float3(cells->to) - convert_float3(cells->from) + (float3)(1.0f);
    return size.x * size.y * size.z > (float)ALTERED_CELLS;
}

static inline uint head_of(int3 cell, uint n_heads)
{
    uint k = (uint)cell.x * 0x9E3779B9u ^ (uint)cell.y * 0x85EBCA6Bu ^ (uint)cell.z * 0xC2B2AE35u;
    k ^= k >> 15;
    k *= 0x2C1B3C6Du;
    return (k ^ k >> 13) & (n_heads - 1u);
}

__kernel void place_altered(PLACE_ALTERED_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_altered);
    aabb around = {(float3)(INFINITY), (float3)(-INFINITY)};
    for (uint i = first; i < last; ++i) {
        uint id = altered[i];
        aabb box = aabb_at(boxes, id);
        is_altered[id] = 1;
        if (!is_there(&box))
            continue;
        cell_range cells = cells_of(&box, per_edge);
        if (are_many(&cells)) {
            wide[atomic_inc(altered_counts + ALTERED_WIDE)] = id;
            continue;
        }
        around = (aabb){fmin(around.lower, box.lower), fmax(around.upper, box.upper)};
        for (int z = cells.from.z; z <= cells.to.z; ++z)
            for (int y = cells.from.y; y <= cells.to.y; ++y)
                for (int x = cells.from.x; x <= cells.to.x; ++x) {
                    uint entry = atomic_inc(altered_counts + ALTERED_ENTRIES);
                    entries[entry] = (int4)(x, y, z, (int)id);
                    nexts[entry] = atomic_xchg(heads + head_of((int3)(x, y, z), n_heads), entry + 1);
                }
    }
    if (is_there(&around))
        put_around(altered_counts, &around);
}

// A body that looks for altered ones.
typedef struct {
    uint id;
    aabb box;
    bool is_altered;
} seeker;

// Two altered bodies are found by the one of the lower id.
static inline bool do_meet(const seeker *s, uint other, const aabb *box)
{
    return other != s->id && !(s->is_altered && other < s->id) && do_overlap(&s->box, box);
}

static inline void put_pair(uint a, uint b, volatile __global uint *counts, uint capacity, __global uint2 *pairs)
{
    uint at = atomic_inc(counts + ALTERED_PAIRS);
    if (at < capacity)
        pairs[at] = (uint2)(a, b);
}

// What a search is told.
typedef struct {
    ARG_FIELDS
} search;

static inline void look_at(const search *a, const seeker *s, uint other, const aabb *box)
{
    if (do_meet(s, other, box))
        put_pair(s->id, other, a->altered_counts, a->pair_capacity, a->found_pairs);
}

// A body of too many cells goes through all that the table has, from one on, `step` apart.
static inline void go_through(const search *a, const seeker *s, uint from, uint step)
{
    for (uint k = from; k < a->n_altered; k += step) {
        const uint other = a->altered[k];
        const aabb box = aabb_at(a->boxes, other);
        const cell_range its = cells_of(&box, a->per_edge);
        if (is_there(&box) && !are_many(&its))
            look_at(a, s, other, &box);
    }
}

// Of the cells that both overlap the first one finds them.
static inline void look_into(const search *a, const seeker *s, const cell_range *cells, int3 cell)
{
    for (uint at = a->heads[head_of(cell, a->n_heads)]; at > 0; at = a->nexts[at - 1]) {
        const int4 entry = a->entries[at - 1];
        if (any(entry.xyz != cell))
            continue;
        const aabb box = aabb_at(a->boxes, (uint)entry.w);
        const int3 begin = max(cells->from, cell_at(box.lower, a->per_edge));
        if (all(begin == cell))
            look_at(a, s, (uint)entry.w, &box);
    }
}

static inline seeker seeker_at(const search *a, uint id)
{
    return (seeker){id, aabb_at(a->boxes, id), a->is_altered[id]};
}

// Returns whether the body still has to go through all.
static inline bool seek(const search *a, const seeker *s, const aabb *around, uint n_wide)
{
    if (!is_there(&s->box))
        return false;
    for (uint k = 0; k < n_wide; ++k) {
        const aabb box = aabb_at(a->boxes, a->wide[k]);
        look_at(a, s, a->wide[k], &box);
    }
    if (!do_overlap(&s->box, around))
        return false;
    const cell_range cells = cells_of(&s->box, a->per_edge);
    if (are_many(&cells))
        return true;
    for (int z = cells.from.z; z <= cells.to.z; ++z)
        for (int y = cells.from.y; y <= cells.to.y; ++y)
            for (int x = cells.from.x; x <= cells.to.x; ++x)
                look_into(a, s, &cells, (int3)(x, y, z));
    return false;
}

#define SHARED 64 // bodies of too many cells with which all work-items of a group help

__kernel void find_altered_pairs(FIND_ALTERED_PAIRS_ARGS)
{
    const search a = {FIND_ALTERED_PAIRS_VALUES};
    const uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    const uint n_wide = altered_counts[ALTERED_WIDE];
    const aabb around = around_table(altered_counts);
#if WG > 1
    __local uint shared[SHARED], n_shared;
    if (get_local_id(0) == 0)
        n_shared = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
#endif
    for (uint id = first; id < last; ++id) {
        const seeker s = seeker_at(&a, id);
        if (!seek(&a, &s, &around, n_wide))
            continue;
#if WG > 1
        const uint at = atomic_inc(&n_shared);
        if (at < SHARED) {
            shared[at] = id;
            continue;
        }
#endif
        go_through(&a, &s, 0, 1);
    }
#if WG > 1
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = 0; k < min(n_shared, (uint)SHARED); ++k) {
        const seeker s = seeker_at(&a, shared[k]);
        go_through(&a, &s, get_local_id(0), WG);
    }
#endif
}

static inline bool is_kept(uint2 link, __global const uint *is_altered, uint n)
{
    return link.y < n && !is_altered[link.x] && !is_altered[link.y];
}

__kernel void keep_pairs(KEEP_PAIRS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_contacts);
    uint kept = 0;
    for (uint i = first; i < last; ++i)
        kept += is_kept(links[i], is_altered, n);
    if (kept == 0)
        return;
    uint at = atomic_add(altered_counts + ALTERED_PAIRS, kept);
    for (uint i = first; i < last && at < pair_capacity; ++i)
        if (is_kept(links[i], is_altered, n))
            found_pairs[at++] = links[i];
}
