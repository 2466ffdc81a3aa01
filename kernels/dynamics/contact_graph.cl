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
typedef struct {
    ARG_FIELDS
} graph;

static inline void count_or_put(volatile __global uint *starts, __global uint *row_values, uint row, uint value, uint fill)
{
    uint at = atomic_inc(starts + row + 1);
    if (fill)
        row_values[at] = value;
}

static inline void put_contact(const graph *g, uint fill, uint owner, uint other)
{
    count_or_put(g->starts, g->others, owner, other, fill);
}

static inline void put_pair(const graph *g, uint fill, uint a, uint b)
{
#if FILTER
    uint2 filter_a = g->filters[a], filter_b = g->filters[b]; // group, mask
    if (!(filter_a.x & filter_b.y) || !(filter_b.x & filter_a.y))
        return;
#endif
#if SENSORS
    if (g->sensors[a] > 0.0f && g->sensors[b] > 0.0f)
        return;
#endif
    bool moves_a = g->velocities[a].w > 0, moves_b = g->velocities[b].w > 0;
    if (moves_a)
        put_contact(g, fill, a, b);
    else if (moves_b)
        put_contact(g, fill, b, a);
#if SENSORS
    else if (g->sensors[a] > 0.0f)
        put_contact(g, fill, a, b);
    else if (g->sensors[b] > 0.0f)
        put_contact(g, fill, b, a);
#endif
}

static inline void put_pairs(const graph *g, uint fill, uint first, uint last)
{
    for (uint i = first; i < last; ++i)
        put_pair(g, fill, min(g->pairs[i].x, g->pairs[i].y), max(g->pairs[i].x, g->pairs[i].y));
}

__kernel void contact_graph_pairs(CONTACT_GRAPH_PAIRS_ARGS)
{
    const graph g = {CONTACT_GRAPH_PAIRS_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    put_pairs(&g, fill, first, min(first + PER_ITEM, n_pairs));
}
#if BOUNDARY

// Walls 2 k and 2 k + 1 are the lower and the upper one of axis k.
static inline void put_walls(const graph *g, uint fill, uint first, uint last)
{
    const real wall[6] = {g->lower.x, g->upper.x, g->lower.y, g->upper.y, g->lower.z, g->upper.z};
    for (uint id = first; id < last; ++id) {
        if (!(g->velocities[id].w > 0))
            continue;
#if SENSORS
        if (g->sensors[id] > 0.0f)
            continue;
#endif
        __global const float *box = g->boxes + 6 * (size_t)id;
        for (uint k = 0; k < DIMS; ++k) {
            if (box[k] < wall[2 * k])
                put_contact(g, fill, id, g->n + 2 * k);
            if (box[3 + k] > wall[2 * k + 1])
                put_contact(g, fill, id, g->n + 2 * k + 1);
        }
    }
}

__kernel void contact_graph_walls(CONTACT_GRAPH_WALLS_ARGS)
{
    const graph g = {CONTACT_GRAPH_WALLS_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    put_walls(&g, fill, first, min(first + PER_ITEM, n));
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
#define GROUND_SHAPE(g) (g)->ground_values, (g)->ground_spacing, (g)->ground_size
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
#define GROUND_SHAPE(g)                                                                          \
    (g)->mesh_nodes, (g)->centres[(g)->carrier], (g)->rotations[(g)->carrier],                    \
        (real4)((g)->velocities[(g)->carrier].xyz, 0),                                            \
        (real4)((g)->angular_velocities[(g)->carrier].xyz, 0), (real)(g)->dt
//@ elseif GROUND == 2 then

// Whether a triangle's bounds come so near to a body's that it could touch the triangle.
static inline bool meets_ground(__global const float *box, real4 origin, __global const uint *nodes, real margin)
{
    real4 lower = (real4)(box[0], box[1], box[2], 0) - origin - margin;
    real4 upper = (real4)(box[3], box[4], box[5], 0) - origin + margin;
    uint at = 0;
    return next_leaf(nodes, &at, lower, upper) != MESH_NONE;
}
#define GROUND_SHAPE(g) (g)->mesh_nodes
//@ end
//@ if GROUND > 0 then

static inline void put_ground(const graph *g, uint fill, uint first, uint last)
{
    for (uint id = first; id < last; ++id) {
        if (!(g->velocities[id].w > 0))
            continue;
#if SENSORS
        if (g->sensors[id] > 0.0f)
            continue;
#endif
        if (meets_ground(g->boxes + 6 * (size_t)id, g->ground_origin, GROUND_SHAPE(g), g->contact_margin))
            for (uint k = 0; k < GROUND_CONTACTS; ++k)
                put_contact(g, fill, id, g->n + AT_GROUND + k);
    }
}

__kernel void contact_graph_ground(CONTACT_GRAPH_GROUND_ARGS)
{
    const graph g = {CONTACT_GRAPH_GROUND_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    put_ground(&g, fill, first, min(first + PER_ITEM, n));
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

static inline void sort_rows(volatile __global const uint *row_starts, __global uint *row_values, uint first, uint last)
{
    for (uint row = first; row < last; ++row) {
        uint start = row_starts[row], size = row_starts[row + 1] - start;
        if (size > 32)
            heap_sort(row_values + start, size);
        else
            insertion_sort(row_values + start, size);
    }
}

__kernel void contact_graph_sort(CONTACT_GRAPH_SORT_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    sort_rows(row_starts, row_values, first, min(first + PER_ITEM, n));
}

// The contacts of rows are links (fill 0).
static inline void put_returns(const graph *g, uint fill, uint first, uint last)
{
    for (uint row = first; row < last; ++row) {
        for (uint i = g->starts[row]; i < g->starts[row + 1]; ++i) {
            uint other = g->others[i];
            if (!fill) {
                g->links[i] = (uint2)(row, other);
                g->touches[i] = 0;
#if CONTACT_RESPONSE
                g->colours[i] = COLOUR_NONE;
#endif
            }
            if (other < g->n && g->velocities[other].w > 0)
                count_or_put(g->return_starts, g->returns, other, i, fill);
        }
    }
}

__kernel void contact_graph_reverse(CONTACT_GRAPH_REVERSE_ARGS)
{
    const graph g = {CONTACT_GRAPH_REVERSE_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    put_returns(&g, fill, first, min(first + PER_ITEM, n));
}

// ------------------------------------------------------------ by a team

#if TEAM

static inline void clear_counts(volatile __global uint *counts, uint2 range)
{
    for (uint i = range.x; i < range.y; ++i)
        counts[i] = 0;
}

static inline uint sum_of(volatile __global const uint *values, uint2 range)
{
    uint sum = 0;
    for (uint i = range.x; i < range.y; ++i)
        sum += values[i];
    return sum;
}

// Makes of a part's values the sums of those before each.
static inline void add_before(volatile __global uint *values, volatile __global const uint *sums, uint place, uint2 range)
{
    uint sum = sum_of(sums, (uint2)(0, place));
    for (uint i = range.x; i < range.y; ++i) {
        uint value = values[i];
        values[i] = sum;
        sum += value;
    }
}

static inline void put_part(const graph *g, uint fill, const team_member *t, uint part)
{
    uint2 of_pairs = range_of(t, part, g->n_pairs), of_bodies = range_of(t, part, g->n);
    put_pairs(g, fill, of_pairs.x, of_pairs.y);
#if BOUNDARY
    put_walls(g, fill, of_bodies.x, of_bodies.y);
#endif
#if GROUND
    put_ground(g, fill, of_bodies.x, of_bodies.y);
#endif
}

// Stages that make sorted rows of contacts, from nothing.
#define ROWS_CLEAR 0
#define ROWS_COUNT 1
#define ROWS_SUM 2
#define ROWS_START 3
#define ROWS_PUT 4
#define ROWS_SORT 5
#define ROWS_STAGES 6

//   reverse  the rows are those of returns
//   counts   [n + 1] of the rows, which become their starts
static inline void make_part(const graph *g, uint stage, const team_member *t, uint part, bool reverse,
                             volatile __global uint *counts, __global uint *values)
{
    const uint fill = stage == ROWS_PUT;
    uint2 of_counts = range_of(t, part, g->n + 1), of_bodies = range_of(t, part, g->n);
    volatile __global uint *sums = t->words + TEAM_SUMS;
    const uint place = place_of(t, part);
    if (stage == ROWS_CLEAR)
        clear_counts(counts, of_counts);
    if (reverse && (stage == ROWS_COUNT || fill))
        put_returns(g, fill, of_bodies.x, of_bodies.y);
    if (!reverse && (stage == ROWS_COUNT || fill))
        put_part(g, fill, t, part);
    if (stage == ROWS_SUM)
        sums[place] = sum_of(counts, of_counts);
    if (stage == ROWS_START)
        add_before(counts, sums, place, of_counts);
    if (stage == ROWS_SORT)
        sort_rows(counts, values, of_bodies.x, of_bodies.y);
}

__kernel void make_rows(MAKE_ROWS_ARGS)
{
    const graph g = {MAKE_ROWS_VALUES};
    team_member t = TEAM_MEMBER;
    uint part, each = parts_of(&t, max(n, n_pairs), TEAM_LEAST_BODIES);
    for (uint k = 0; k < ROWS_STAGES; ++k) {
        IN_STAGE(&t, &part, each)
            make_part(&g, k, &t, part, false, starts, others);
        END_STAGE(&t);
    }
}

__kernel void make_returns(MAKE_RETURNS_ARGS)
{
    const graph g = {MAKE_RETURNS_VALUES};
    team_member t = TEAM_MEMBER;
    uint part, each = parts_of(&t, n, TEAM_LEAST_BODIES);
    for (uint k = 0; k < ROWS_STAGES; ++k) {
        IN_STAGE(&t, &part, each)
            make_part(&g, k, &t, part, true, return_starts, returns);
        END_STAGE(&t);
    }
}

#endif
