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

// Takes contacts: rows that are counted in `starts`, which a scan sums, and then written to `values`; by a team first
// buckets of rows, each with its next place.
typedef struct {
    uint fill; // 0: counts, 1: writes
    volatile __global uint *starts;
    __global uint *values;
    uint *places; // of each bucket; NULL: rows
    uint shift;
    __global uint *rows;
} row_sink;

static inline void put_in_row(const row_sink *to, uint row, uint value)
{
    uint at = to->places ? to->places[row >> to->shift]++ : atomic_inc(to->starts + row + 1);
    if (to->fill)
        to->values[at] = value;
    if (to->fill && to->places)
        to->rows[at] = row;
}

static inline void put_pair(const graph *g, const row_sink *to, uint a, uint b)
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
        put_in_row(to, a, b);
    else if (moves_b)
        put_in_row(to, b, a);
#if SENSORS
    else if (g->sensors[a] > 0.0f)
        put_in_row(to, a, b);
    else if (g->sensors[b] > 0.0f)
        put_in_row(to, b, a);
#endif
}

static inline void put_pairs(const graph *g, const row_sink *to, uint first, uint last)
{
    for (uint i = first; i < last; ++i)
        put_pair(g, to, min(g->pairs[i].x, g->pairs[i].y), max(g->pairs[i].x, g->pairs[i].y));
}

#if BOUNDARY

// Walls 2 k and 2 k + 1 are the lower and the upper one of axis k.
static inline void put_walls(const graph *g, const row_sink *to, uint first, uint last)
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
                put_in_row(to, id, g->n + 2 * k);
            if (box[3 + k] > wall[2 * k + 1])
                put_in_row(to, id, g->n + 2 * k + 1);
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

static inline void put_ground(const graph *g, const row_sink *to, uint first, uint last)
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
                put_in_row(to, id, g->n + AT_GROUND + k);
    }
}
//@ end

// Puts walls and the ground, which never move.
static inline void put_fixed(const graph *g, const row_sink *to, uint first, uint last)
{
#if BOUNDARY
    put_walls(g, to, first, last);
#endif
#if GROUND
    put_ground(g, to, first, last);
#endif
}

// Work-items take pairs, and as many bodies.
__kernel void contact_graph_rows(CONTACT_GRAPH_ROWS_ARGS)
{
    const graph g = {CONTACT_GRAPH_ROWS_VALUES};
    const row_sink to = {.fill = fill, .starts = starts, .values = others};
    const uint first = get_global_id(0) * PER_ITEM, last = first + PER_ITEM;
    put_pairs(&g, &to, first, min(last, n_pairs));
    put_fixed(&g, &to, first, min(last, n));
}

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

#define SHORT_ROW 32

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

static inline void sort_row(__global uint *values, uint n)
{
    if (n > SHORT_ROW)
        heap_sort(values, n);
    else
        insertion_sort(values, n);
}
#if WG > 1

// Sorts n values while it reads them, in local memory: a work-item's lie WG apart.
static inline void sort_short_row(__global uint *values, uint n, __local uint *own)
{
    for (uint i = 0; i < n; ++i) {
        uint value = values[i], at = i;
        for (; at > 0 && own[(at - 1) * WG] > value; --at)
            own[at * WG] = own[(at - 1) * WG];
        own[at * WG] = value;
    }
    for (uint i = 0; i < n; ++i)
        values[i] = own[i * WG];
}
#endif

__kernel void contact_graph_sort(CONTACT_GRAPH_SORT_ARGS)
{
#if WG > 1
    __local uint short_rows[SHORT_ROW * WG];
#endif
    uint first = get_global_id(0) * PER_ITEM;
    for (uint row = first; row < min(first + PER_ITEM, n); ++row) {
        __global uint *values = row_values + row_starts[row];
        uint n_values = row_starts[row + 1] - row_starts[row];
#if WG > 1
        if (n_values <= SHORT_ROW)
            sort_short_row(values, n_values, short_rows + get_local_id(0));
        else
#endif
            sort_row(values, n_values);
    }
}

// The contacts of rows are links (fill 0).
static inline void begin_contact(const graph *g, uint i, uint row, uint other)
{
    g->links[i] = (uint2)(row, other);
    g->touches[i] = 0;
#if CONTACT_RESPONSE
    g->colours[i] = COLOUR_NONE;
#endif
}

// Contacts of a row that a GPU takes together, so that it waits for their others once.
#if WG > 1
#define TAKEN 4
#else
#define TAKEN 1
#endif

static inline void put_returns(const graph *g, const row_sink *to, uint first, uint last)
{
    for (uint row = first; row < last; ++row) {
        const uint end = g->starts[row + 1];
        for (uint i = g->starts[row]; i < end; i += TAKEN) {
            uint others[TAKEN];
            bool moves[TAKEN];
#pragma unroll
            for (uint k = 0; k < TAKEN; ++k)
                others[k] = g->others[min(i + k, end - 1)];
#pragma unroll
            for (uint k = 0; k < TAKEN; ++k)
                moves[k] = (g->velocities[min(others[k], g->n - 1)].w > 0) & (others[k] < g->n) & (i + k < end);
#pragma unroll
            for (uint k = 0; k < TAKEN; ++k) {
                if (!to->fill && i + k < end)
                    begin_contact(g, i + k, row, others[k]);
                if (moves[k])
                    put_in_row(to, others[k], i + k);
            }
        }
    }
}

__kernel void contact_graph_reverse(CONTACT_GRAPH_REVERSE_ARGS)
{
    const graph g = {CONTACT_GRAPH_REVERSE_VALUES};
    const row_sink to = {.fill = fill, .starts = return_starts, .values = returns};
    uint first = get_global_id(0) * PER_ITEM;
    put_returns(&g, &to, first, min(first + PER_ITEM, n));
}

// ------------------------------------------------------------ by a team

#if TEAM

// Makes sorted rows of contacts in three stages, whose groups write to no line of another: each part counts what it
// finds by buckets, which are rows that follow each other; then it writes that to its places in each bucket; then each
// bucket's rows are made of what lies there.
//
//   row_counts   [parts][ROW_BUCKETS], and then where each bucket begins, and the last one ends
//   entry_rows, entry_values  by bucket
//   each         parts of a group
typedef struct {
    uint parts, n_rows, shift;
    __global uint *counts, *begins;
    row_sink to; // entries
} bucket_maker;

static inline bucket_maker make_buckets(const team_member *t, uint each, uint n_rows, __global uint *counts,
                                        __global uint *entry_rows, __global uint *entry_values)
{
    bucket_maker m = {.parts = t->groups * each, .n_rows = n_rows, .shift = ROW_LEAST_SHIFT, .counts = counts};
    while ((n_rows - 1) >> m.shift >= ROW_BUCKETS)
        ++m.shift;
    m.begins = counts + m.parts * ROW_BUCKETS;
    m.to = (row_sink){.shift = m.shift, .values = entry_values, .rows = entry_rows};
    return m;
}

static inline uint count_buckets(const bucket_maker *m)
{
    return ((m->n_rows - 1) >> m->shift) + 1;
}

// Begins a part's counts at 0, or its places behind those of lesser buckets and of parts before it.
static inline void begin_part(bucket_maker *m, uint place, uint fill, uint places[ROW_BUCKETS])
{
    uint n = count_buckets(m), sum = 0;
    m->to.fill = fill;
    m->to.places = places;
    for (uint b = 0; b < n; ++b) {
        if (fill && place == 0)
            m->begins[b] = sum;
        places[b] = fill ? sum : 0;
        for (uint q = 0; fill && q < m->parts; ++q) {
            uint count = m->counts[q * ROW_BUCKETS + b];
            places[b] += q < place ? count : 0;
            sum += count;
        }
    }
    if (fill && place == 0)
        m->begins[n] = sum;
}

static inline void end_part(const bucket_maker *m, uint place)
{
    for (uint b = 0; !m->to.fill && b < count_buckets(m); ++b)
        m->counts[place * ROW_BUCKETS + b] = m->to.places[b];
}

// Makes the rows from `from` up to `to` of the entries between x and y, each row in the order of its entries.
static inline void make_bucket(const row_sink *entries, uint2 at, uint from, uint to, volatile __global uint *starts,
                               __global uint *values)
{
    for (uint row = from; row < to; ++row)
        starts[row] = 0;
    for (uint k = at.x; k < at.y; ++k)
        starts[entries->rows[k]] += 1;
    for (uint row = from, sum = at.x; row < to; ++row) {
        uint count = starts[row];
        starts[row] = sum;
        sum += count;
    }
    for (uint k = at.x; k < at.y; ++k) {
        uint row = entries->rows[k], place = starts[row];
        starts[row] = place + 1;
        values[place] = entries->values[k];
    }
    for (uint row = from, start = at.x; row < to; ++row) { // a row's start was moved to its end
        uint end = starts[row];
        starts[row] = start;
        start = end;
    }
}

static inline void make_rows_of(const bucket_maker *m, uint2 range, volatile __global uint *starts, __global uint *values)
{
    for (uint b = range.x; b < range.y; ++b) {
        uint from = b << m->shift, to = min(from + (1u << m->shift), m->n_rows);
        uint2 at = (uint2)(m->begins[b], m->begins[b + 1]);
        make_bucket(&m->to, at, from, to, starts, values);
        if (to == m->n_rows)
            starts[to] = at.y;
    }
}

// Ranks eight values among n: how many are less.
static inline uint8 ranks_among(const uint *values, uint n, uint8 own)
{
    uint8 ranks = 0;
    for (uint k = 0; k < n; ++k)
        ranks -= as_uint8(own > values[k]);
    return ranks;
}

// Sorts 16 different values at most: each goes behind those that are less, without a branch that depends on them.
static inline void rank_sort(__global uint *values, uint n)
{
    uint each[16] = {0}, ranks[16];
    for (uint k = 0; k < n; ++k)
        each[k] = values[k];
    for (uint k = 0; k < n; k += 8)
        vstore8(ranks_among(each, n, vload8(0, each + k)), 0, ranks + k);
    for (uint k = 0; k < n; ++k)
        values[ranks[k]] = each[k];
}

// Sorts the rows of those buckets. The start behind the last one is another group's, which may not have written it yet.
static inline void sort_rows_of(const bucket_maker *m, uint2 range, volatile __global const uint *starts,
                                __global uint *values)
{
    uint from = min(range.x << m->shift, m->n_rows), to = min(range.y << m->shift, m->n_rows);
    for (uint row = from; row < to; ++row) {
        uint start = starts[row], n = (row + 1 < to ? starts[row + 1] : m->begins[range.y]) - start;
        if (n > 4 && n <= 16)
            rank_sort(values + start, n);
        else if (n > 1)
            sort_row(values + start, n);
    }
}

static inline void put_part(const graph *g, const row_sink *to, const team_member *t, uint part)
{
    uint2 of_pairs = range_of(t, part, g->n_pairs), of_bodies = range_of(t, part, g->n);
    put_pairs(g, to, of_pairs.x, of_pairs.y);
    put_fixed(g, to, of_bodies.x, of_bodies.y);
}

__kernel void make_rows(MAKE_ROWS_ARGS)
{
    const graph g = {MAKE_ROWS_VALUES};
    team_member t = TEAM_MEMBER;
    uint part, places[ROW_BUCKETS], each = min(parts_of(&t, max(n, n_pairs), TEAM_LEAST_BODIES), (uint)ROW_PARTS);
    bucket_maker m = make_buckets(&t, each, n, row_counts, entry_rows, entry_values);
    for (uint fill = 0; fill < 2; ++fill) {
        IN_STAGE(&t, &part, each) {
            begin_part(&m, place_of(&t, part), fill, places);
            put_part(&g, &m.to, &t, part);
            end_part(&m, place_of(&t, part));
        }
        END_STAGE(&t);
    }
    IN_STAGE(&t, &part, parts_of(&t, n, TEAM_LEAST_BODIES)) {
        uint2 range = range_of(&t, part, count_buckets(&m));
        make_rows_of(&m, range, starts, others);
        sort_rows_of(&m, range, starts, others);
    }
}

__kernel void make_returns(MAKE_RETURNS_ARGS)
{
    const graph g = {MAKE_RETURNS_VALUES};
    team_member t = TEAM_MEMBER;
    uint part, places[ROW_BUCKETS], each = min(parts_of(&t, n, TEAM_LEAST_BODIES), (uint)ROW_PARTS);
    bucket_maker m = make_buckets(&t, each, n, row_counts, entry_rows, entry_values);
    for (uint fill = 0; fill < 2; ++fill) {
        IN_STAGE(&t, &part, each) {
            uint2 range = range_of(&t, part, n);
            begin_part(&m, place_of(&t, part), fill, places);
            put_returns(&g, &m.to, range.x, range.y);
            end_part(&m, place_of(&t, part));
        }
        END_STAGE(&t);
    }
    IN_STAGE(&t, &part, parts_of(&t, n, TEAM_LEAST_BODIES))
        make_rows_of(&m, range_of(&t, part, count_buckets(&m)), return_starts, returns);
}

#endif
