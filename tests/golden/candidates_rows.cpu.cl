// candidates_rows.DIMS2.IDS0.WG1.BUF512.PER_ITEM256
#define DIMS 2
#define IDS 0
#define WG 1
#define BUF 512
#define PER_ITEM 256
#line 1 "kernels/common.clh"
#line 1 "kernels/candidates_rows.cl.in"
// SPDX-License-Identifier: MIT
// Pairs whose bounds overlap, from objects in cell order.
//
// Each pair is found from the object that comes first in that order, so half
// the neighbourhood is enough, and three cells side by side in x are one range:
// what follows in the own row, and the rows that gen/emit/stencil.lua gives, one
// in 2D and four in 3D. Pairs collect in local memory; one atomic takes room for many.
//
//   bounds [n][2]        lower xyz and the id, upper xyz and the cell
//   starts [n_cells + 1] first of each cell; an empty one begins with the next
//   found  [room]        pairs of places (IDS 0) or of ids (IDS 1)
static inline bool bounds_overlap(float4 lower_a, float4 upper_a, float4 lower_b, float4 upper_b)
{
    int4 apart = (lower_a > upper_b) | (lower_b > upper_a);
#if DIMS == 3
    return !any(apart.xyz);
#else
    return !any(apart.xy);
#endif
}

typedef struct {
    __local uint2 *pairs;
    volatile __local uint *used;
    __global uint2 *found;
    uint room;
    volatile __global uint *counter;
} pair_sink;

static inline void add_pair(pair_sink *sink, uint2 pair)
{
    uint slot = atomic_inc(sink->used);
    if (slot < BUF) {
        sink->pairs[slot] = pair;
    } else { // the buffer is full until the next flush
        uint to = reserve(sink->counter, 1);
        if (to < sink->room)
            sink->found[to] = pair;
    }
}

static inline void search_range(pair_sink *sink, __global const float4 *bounds, uint i, uint from,
                                uint to, float4 lower, float4 upper)
{
    for (uint j = from; j < to; ++j) {
        float4 other_lower = bounds[2 * (size_t)j];
        float4 other_upper = bounds[2 * (size_t)j + 1];
        if (bounds_overlap(lower, upper, other_lower, other_upper)) {
#if IDS
            add_pair(sink, ordered(as_uint(lower.w), as_uint(other_lower.w)));
#else
            add_pair(sink, (uint2)(i, j));
#endif
        }
    }
}

static inline void search_rows(pair_sink *sink, __global const float4 *bounds,
                               __global const uint *starts, uint i, int4 cells, uint n_cells)
{
    float4 lower = bounds[2 * (size_t)i];
    float4 upper = bounds[2 * (size_t)i + 1];
    uint key = as_uint(upper.w);
    if (key >= n_cells)
        return;
    uint nx = (uint)cells.x;
    uint x = key % nx;
    uint left = x > 0 ? 1 : 0;
    uint right = x + 1 < nx ? 1 : 0;
#line 71 "kernels/candidates_rows.cl.in"
    uint ny = (uint)cells.y;
    uint row_y = nx;
    uint y = key / row_y;
#line 75 "kernels/candidates_rows.cl.in"
    search_range(sink, bounds, i, i + 1, starts[key + right + 1], lower, upper);
#line 77 "kernels/candidates_rows.cl.in"
    if (y + 1 < ny) {
        uint at = key + row_y;
        search_range(sink, bounds, i, starts[at - left], starts[at + right + 1], lower, upper);
    }
#line 82 "kernels/candidates_rows.cl.in"
}

// Moves what the group collected to global memory.
static inline void flush(pair_sink *sink, __local uint *base)
{
    uint n = min(*sink->used, (uint)BUF);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0) {
        *base = reserve(sink->counter, n);
        *sink->used = 0;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = get_local_id(0); k < n; k += WG) {
        uint to = *base + k;
        if (to < sink->room)
            sink->found[to] = sink->pairs[k];
    }
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
candidates_rows(__global const float4 *restrict bounds, __global const uint *restrict starts,
                uint first, uint last, int4 cells, uint n_cells, __global uint2 *restrict found,
                uint room, volatile __global uint *restrict counters)
{
    __local uint2 pairs[BUF];
    __local uint used;
    __local uint base;
    pair_sink sink = {pairs, &used, found, room, counters + (IDS ? COUNT_PAIRS : COUNT_CANDIDATES)};
    if (get_local_id(0) == 0)
        used = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint tile = first + get_group_id(0) * WG * PER_ITEM;
    for (uint round = 0; round < PER_ITEM; ++round) {
        uint i = tile + round * WG + get_local_id(0);
        if (i < last)
            search_rows(&sink, bounds, starts, i, cells, n_cells);
        barrier(CLK_LOCAL_MEM_FENCE);
        if (used > BUF / 2 || round + 1 == PER_ITEM)
            flush(&sink, &base);
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}
