// contact_graph.DIMS2.DOUBLE0.BOUNDARY0.CONTACT_RESPONSE0.FILTER0.SENSORS0.WG1.PER_ITEM1024
#define DIMS 2
#define DOUBLE 0
#define BOUNDARY 0
#define CONTACT_RESPONSE 0
#define FILTER 0
#define SENSORS 0
#define WG 1
#define PER_ITEM 1024
#define CONTACT_GRAPH_PAIRS_ARGS \
    __global const uint2 *restrict pairs, \
    uint n_pairs, \
    __global const float4 *restrict velocities, \
    uint fill, \
    volatile __global uint *restrict starts, \
    __global uint *restrict others
#define CONTACT_GRAPH_REVERSE_ARGS \
    __global const uint *restrict starts, \
    __global const uint *restrict others, \
    uint n, \
    __global const float4 *restrict velocities, \
    uint fill, \
    __global uint2 *restrict links, \
    __global uint *restrict touches, \
    volatile __global uint *restrict return_starts, \
    __global uint *restrict returns
#define CONTACT_GRAPH_SORT_ARGS \
    __global const uint *restrict row_starts, \
    uint n, \
    __global uint *restrict row_values
#define CONTACT_GRAPH_WALLS_ARGS \
    __global const float *restrict boxes, \
    __global const float4 *restrict velocities, \
    float4 lower, \
    float4 upper, \
    uint n, \
    uint fill, \
    volatile __global uint *restrict starts, \
    __global uint *restrict others
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact_graph.cl.in"
// SPDX-License-Identifier: MIT
// The contact graph in compressed sparse rows: for each body the ascending ids of
// those that it may touch. A body that never moves has no row, so that a floor's is
// not long; two such bodies are no pair.
//
// Each list is made in two launches of the same kernel: one counts into
// starts, which a scan sums, and one fills. starts[o + 1] is then where row o
// ends, and so where row o + 1 begins.
//
//   starts  [n + 1]
//   others  [n_contacts] the other's id; n + k: wall k
//   links   [n_contacts] owner and other of each contact
//   touches, colours  as of contacts that begin
//   returns [n_returns]  for each object the contacts where it is the other
static inline void count_or_put(volatile __global uint *starts, __global uint *row_values, uint row, uint value, uint fill)
{
    uint at = atomic_inc(starts + row + 1);
    if (fill)
        row_values[at] = value;
}

__kernel void contact_graph_pairs(CONTACT_GRAPH_PAIRS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_pairs);
    for (uint i = first; i < last; ++i) {
        uint a = min(pairs[i].x, pairs[i].y), b = max(pairs[i].x, pairs[i].y);
#line 37 "kernels/dynamics/contact_graph.cl.in"
        bool moves_a = velocities[a].w > 0, moves_b = velocities[b].w > 0;
        if (moves_a)
            count_or_put(starts, others, a, b, fill);
        else if (moves_b)
            count_or_put(starts, others, b, a, fill);
#line 48 "kernels/dynamics/contact_graph.cl.in"
    }
}
#line 74 "kernels/dynamics/contact_graph.cl.in"

static inline void sink_down(__global uint *values, uint at, uint n)
{
    uint value = values[at];
    for (uint child = 2 * at + 1; child < n; child = 2 * at + 1) {
        if (child + 1 < n && values[child + 1] > values[child])
            ++child;
        if (values[child] <= value)
            break;
        values[at] = values[child];
        at = child;
    }
    values[at] = value;
}

static inline void heap_sort(__global uint *values, uint n)
{
    for (uint i = n / 2; i > 0; --i)
        sink_down(values, i - 1, n);
    for (uint end = n - 1; end > 0; --end) {
        uint greatest = values[0];
        values[0] = values[end];
        values[end] = greatest;
        sink_down(values, 0, end);
    }
}

static inline void insertion_sort(__global uint *values, uint n)
{
    for (uint i = 1; i < n; ++i) {
        uint value = values[i];
        uint at = i;
        for (; at > 0 && values[at - 1] > value; --at)
            values[at] = values[at - 1];
        values[at] = value;
    }
}

__kernel void contact_graph_sort(CONTACT_GRAPH_SORT_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint row = first; row < last; ++row) {
        uint size = row_starts[row + 1] - row_starts[row];
        if (size > 32)
            heap_sort(row_values + row_starts[row], size);
        else
            insertion_sort(row_values + row_starts[row], size);
    }
}

__kernel void contact_graph_reverse(CONTACT_GRAPH_REVERSE_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint row = first; row < last; ++row) {
        for (uint i = starts[row]; i < starts[row + 1]; ++i) {
            uint other = others[i];
            if (!fill) {
                links[i] = (uint2)(row, other);
                touches[i] = 0;
#line 138 "kernels/dynamics/contact_graph.cl.in"
            }
            if (other < n && velocities[other].w > 0)
                count_or_put(return_starts, returns, other, i, fill);
        }
    }
}
