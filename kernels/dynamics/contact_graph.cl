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
//   others  [n_contacts] the other's id; n + k: wall k; from n + AT_GROUND on the ground
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
#if FILTER
        uint2 filter_a = filters[a], filter_b = filters[b]; // group, mask
        if (!(filter_a.x & filter_b.y) || !(filter_b.x & filter_a.y))
            continue;
#endif
#if SENSORS
        if (sensors[a] > 0.0f && sensors[b] > 0.0f)
            continue;
#endif
        bool moves_a = velocities[a].w > 0, moves_b = velocities[b].w > 0;
        if (moves_a)
            count_or_put(starts, others, a, b, fill);
        else if (moves_b)
            count_or_put(starts, others, b, a, fill);
#if SENSORS
        else if (sensors[a] > 0.0f)
            count_or_put(starts, others, a, b, fill);
        else if (sensors[b] > 0.0f)
            count_or_put(starts, others, b, a, fill);
#endif
    }
}
#if BOUNDARY

// Walls 2 k and 2 k + 1 are the lower and the upper one of axis k.
__kernel void contact_graph_walls(CONTACT_GRAPH_WALLS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    const real wall[6] = {lower.x, upper.x, lower.y, upper.y, lower.z, upper.z};
    for (uint id = first; id < last; ++id) {
        if (!(velocities[id].w > 0))
            continue;
#if SENSORS
        if (sensors[id] > 0.0f)
            continue;
#endif
        for (uint k = 0; k < DIMS; ++k) {
            if (boxes[6 * (size_t)id + k] < wall[2 * k])
                count_or_put(starts, others, id, n + 2 * k, fill);
            if (boxes[6 * (size_t)id + 3 + k] > wall[2 * k + 1])
                count_or_put(starts, others, id, n + 2 * k + 1, fill);
        }
    }
}
#endif
//@ if GROUND == 1 then

// The places of the grid from one before a coordinate, or to one behind it.
static inline int place_before(real at, int n)
{
    return (int)clamp(floor(at) - 1, (real)0, (real)(n - 1));
}

static inline int place_behind(real at, int n)
{
    return (int)clamp(floor(at) + 2, (real)0, (real)(n - 1));
}

// Whether the ground under bounds comes so near to them that a body within could touch it.
static inline bool meets_ground(__global const float *box, real4 origin, __global const float *heights, real4 spacing,
                                int4 size, real margin)
{
    real x = (box[0] - margin - origin.x) * spacing.z, x_end = (box[3] + margin - origin.x) * spacing.z;
    real y = (box[1] - margin - origin.y) * spacing.w, y_end = (box[4] + margin - origin.y) * spacing.w;
    if (!(x_end >= -1 && y_end >= -1 && x <= size.x && y <= size.y))
        return false;
    for (int j = place_before(y, size.y); j <= place_behind(y_end, size.y); ++j)
        for (int i = place_before(x, size.x); i <= place_behind(x_end, size.x); ++i)
            if (origin.z + heights[(size_t)j * size.x + i] >= box[2] - margin)
                return true;
    return false;
}
#define GROUND_SHAPE ground_values, ground_spacing, ground_size
//@ end
//@ if CARRIED == 1 then

// Likewise of a mesh that a body carries, wherever it goes in a step.
static inline bool meets_ground(__global const float *box, real4 origin, __global const uint *nodes, real4 centre,
                                real4 rotation, real4 velocity, real4 angular_velocity, real dt, real margin)
{
    real4 lower = (real4)(box[0], box[1], box[2], 0) - centre, upper = (real4)(box[3], box[4], box[5], 0) - centre;
    real4 middle = (real)0.5 * (lower + upper), half_size = (real)0.5 * (upper - lower);
    real4 way = velocity + cross_product(angular_velocity, middle), turn = conjugate(rotation);
    real most = root(dot_product(half_size, half_size)) * root(dot_product(angular_velocity, angular_velocity));
    real reach = dt * (root(dot_product(way, way)) + most) + margin;
    real4 seen = rotated(turn, (real4)(middle.xyz, 0)) - origin;
    half_size = box_reach(turn, (real4)(half_size.xyz, 0)) * (real)(1 + 0x1p-10) + reach;
    uint at = 0;
    return next_leaf(nodes, &at, seen - half_size, seen + half_size) != MESH_NONE;
}
#define GROUND_SHAPE                                                                             \
    mesh_nodes, centres[carrier], rotations[carrier], (real4)(velocities[carrier].xyz, 0),       \
        (real4)(angular_velocities[carrier].xyz, 0), (real)dt
//@ elseif GROUND == 2 then

// Whether a triangle's bounds come so near to a body's that it could touch the triangle.
static inline bool meets_ground(__global const float *box, real4 origin, __global const uint *nodes, real margin)
{
    real4 lower = (real4)(box[0], box[1], box[2], 0) - origin - margin;
    real4 upper = (real4)(box[3], box[4], box[5], 0) - origin + margin;
    uint at = 0;
    return next_leaf(nodes, &at, lower, upper) != MESH_NONE;
}
#define GROUND_SHAPE mesh_nodes
//@ end
//@ if GROUND > 0 then

__kernel void contact_graph_ground(CONTACT_GRAPH_GROUND_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        if (!(velocities[id].w > 0))
            continue;
#if SENSORS
        if (sensors[id] > 0.0f)
            continue;
#endif
        __global const float *box = boxes + 6 * (size_t)id;
        if (meets_ground(box, ground_origin, GROUND_SHAPE, contact_margin))
            for (uint k = 0; k < GROUND_CONTACTS; ++k)
                count_or_put(starts, others, id, n + AT_GROUND + k, fill);
    }
}
//@ end

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
#if CONTACT_RESPONSE
                colours[i] = COLOUR_NONE;
#endif
            }
            if (other < n && velocities[other].w > 0)
                count_or_put(return_starts, returns, other, i, fill);
        }
    }
}
