// SPDX-License-Identifier: MIT
// Which boxes of a tree (queries/tree.h) are at points: those that contain them (WANTS
// EVERY), or the `each` nearest ones.
//
//   items    [n][3] points
//   order    [n] of them; in_order 1: as they come
//   boxes, nodes    of the tree
//   levels   [n_levels] first node of each level, the lowest first
//   hits     [hits_capacity][3] point, id, 0, in any order; of nearest ones [n][each][3] with
//            the square of the distance, by that and id
//   open     [open_capacity][3] boxes that float leaves to the host
//
// The result does not depend on the tree: a box is never nearer than its bounds, nor these
// than wider ones, for each operation on the way is monotone.
//@ if ORIGIN > 0 then
#define POINT_WORDS 6 // then the cell
//@ else
#define POINT_WORDS 3
//@ end
#define EVERY 2
#define NEAREST 3
#define HIT_WORDS 3

#define SLACK (64.0f * 0x1p-24f) // of a box's size, as seen from the point
#define LEAST_SIZE 0x1p-70f
#define GREATEST_SIZE 0x1p110f
//@ if SHAPE >= 2 then
#define LEAST_SQUARED 0x1p-50f // their squares are floats
#define GREATEST_SQUARED 0x1p60f
//@ end

struct traversal {
    float point[3];
//@ if ORIGIN > 0 then
    far_item item;
    float lower[3], upper[3]; // around the point, from the tree's middle
//@ end
    __global const float *boxes;
//@ if FILTERED == 1 then
    filter filter;
//@ end
    uint number;
    __global uint *hits;
    volatile __global uint *counters;
#if WANTS == EVERY
    uint hits_capacity;
    __global uint *open;
    uint open_capacity;
#else
    uint each, n; // the point's row has n hits
    float worst;  // of them, once there are as many as asked for
#endif
};

static inline bool point_is_bad(const float point[3])
{
    bool bad = false;
    for (int k = 0; k < DIMS; ++k)
        bad = bad || !(fabs(point[k]) <= MOST_COORDINATE);
    return bad;
}

static inline float farthest(const traversal *w)
{
#if WANTS == EVERY
    return 0.0f;
#else
    return w->worst;
#endif
}

// The square of the distance to bounds; 0 where they hold the point, for a difference has
// the right sign.
static inline row_mask meets_bounds(const traversal *w, __global const float *node, row *from)
{
    row square = (row)(0.0f);
    row_mask beside = (row_mask)(0);
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        row lower = load_row(node + k * TREE_WIDTH), upper = load_row(node + (3 + k) * TREE_WIDTH);
//@ if ORIGIN > 0 then
        row from_point = (row)(w->lower[k]), to_point = (row)(w->upper[k]);
        row beyond = fmax(fmax(lower - to_point, from_point - upper), (row)(0.0f));
        square = fma(beyond, beyond, square);
        beside |= WANTS == EVERY ? (lower > to_point) | (upper < from_point) : lower > upper; // no box here
    }
    square *= 1.0f - NODE_SLACK;
//@ else
        row point = (row)(w->point[k]);
        row beyond = fmax(fmax(lower - point, point - upper), (row)(0.0f));
        square = fma(beyond, beyond, square);
        beside |= WANTS == EVERY ? (lower > point) | (upper < point) : lower > upper; // no box here
    }
//@ end
    *from = WANTS == EVERY ? (row)(0.0f) : square;
    return !beside;
}

// How far beyond the two faces across an edge the point is; below 0: inside.
static inline float beyond_faces(const traversal *w, __global const float *box, const float way[3], int k)
{
//@ if SHAPE >= 2 then
    __global const float *axis = box + TREE_BOX_AXES + 3 * k;
    return fabs(fma(axis[0], way[0], DIMS == 3 ? fma(axis[1], way[1], axis[2] * way[2]) : axis[1] * way[1])) -
           box[3 + k];
//@ else
#if SHAPE // bounds
    return fmax(box[k] - w->point[k], w->point[k] - box[3 + k]);
#elif DIMS == 3
    __global const float *axis = box + TREE_BOX_AXES + 3 * k;
    return fabs(fma(axis[0], way[0], fma(axis[1], way[1], axis[2] * way[2]))) - box[3 + k];
#else
    __global const float *axis = box + TREE_BOX_AXES + 3 * k;
    return fabs(fma(axis[0], way[0], axis[1] * way[1])) - box[3 + k];
#endif
//@ end
}
//@ if SHAPE >= 2 then

// sqrt(x) within 4 ulp, for x in 2^-100 .. 2^100, or 0; a device's own root may be another.
static inline float root_of(float x)
{
    float inverse = as_float(0x5F3759DFu - (as_uint(x) >> 1));
    for (int step = 0; step < 4; ++step)
        inverse *= fma(-0.5f * x * inverse, inverse, 1.5f);
    return x * inverse;
}
//@ end

#if WANTS == EVERY

static inline void list_hit(__global uint *row, uint number, uint id)
{
    if (!row)
        return;
    row[0] = number;
    row[1] = id;
    row[2] = 0;
}

static inline bool visit_box(traversal *w, uint slot, float from)
{
    __global const float *box = w->boxes + (size_t)slot * TREE_BOX_WORDS;
//@ if FILTERED == 1 then
    if (!can_touch(&w->filter, as_uint(box[TREE_BOX_ID])))
        return false;
//@ end
    bool open = false;
//@ if SHAPE >= 2 then
    float way[3], radius = box[TREE_BOX_RADIUS], size = radius, square = 0.0f;
    for (int k = 0; k < DIMS; ++k) {
//@ if ORIGIN > 0 then
        way[k] = far_way(&w->item, box, k);
//@ else
        way[k] = w->point[k] - box[k];
//@ end
        size += fabs(way[k]) + box[3 + k];
    }
    float doubt = 2.0f * SLACK * size;
    bool known = size >= LEAST_SQUARED && size <= GREATEST_SQUARED, inside = true;
    for (int k = 0; k < DIMS; ++k) {
        float beyond = beyond_faces(w, box, way, k);
        inside = inside && beyond < -doubt;
        beyond = fmax(beyond, 0.0f);
        square = fma(beyond, beyond, square);
    }
    float near = radius - doubt, far = radius + doubt;
    if (known && square > far * far)
        return false;
    open = !known || !(inside || (near > 0.0f && square < near * near));
//@ else
#if !SHAPE
    float way[3], size = 0.0f;
    for (int k = 0; k < DIMS; ++k) {
//@ if ORIGIN > 0 then
        way[k] = far_way(&w->item, box, k);
//@ else
        way[k] = w->point[k] - box[k];
//@ end
        size += fabs(way[k]) + box[3 + k];
    }
    float doubt = SLACK * size;
    bool known = size >= LEAST_SIZE && size <= GREATEST_SIZE;
    open = !known;
    for (int k = 0; k < DIMS; ++k) {
        float beyond = beyond_faces(w, box, way, k);
        if (known && beyond > doubt)
            return false;
        open = open || beyond >= -doubt;
    }
#endif
//@ end
    uint id = as_uint(box[TREE_BOX_ID]);
    if (open)
        list_hit(add_row(w->open, w->open_capacity, w->counters + COUNT_OPEN, HIT_WORDS), w->number, id);
    else
        list_hit(add_row(w->hits, w->hits_capacity, w->counters + COUNT_HITS, HIT_WORDS), w->number, id);
    return false;
}

#else

// Into the point's row, which is sorted.
static inline void keep_hit(traversal *w, uint id, float square)
{
    uint at = w->n < w->each ? w->n++ : w->each - 1;
    for (; at > 0; --at) {
        __global const uint *other = w->hits + (size_t)(at - 1) * HIT_WORDS;
        float of_other = as_float(other[2]);
        if (of_other < square || (of_other == square && other[1] < id))
            break;
        w->hits[(size_t)at * HIT_WORDS + 1] = other[1];
        w->hits[(size_t)at * HIT_WORDS + 2] = other[2];
    }
    w->hits[(size_t)at * HIT_WORDS + 1] = id;
    w->hits[(size_t)at * HIT_WORDS + 2] = as_uint(square);
    if (w->n == w->each)
        w->worst = as_float(w->hits[(size_t)(w->each - 1) * HIT_WORDS + 2]);
}

static inline bool visit_box(traversal *w, uint slot, float from)
{
    __global const float *box = w->boxes + (size_t)slot * TREE_BOX_WORDS;
//@ if FILTERED == 1 then
    if (!can_touch(&w->filter, as_uint(box[TREE_BOX_ID])))
        return false;
//@ end
    uint id = as_uint(box[TREE_BOX_ID]);
    float way[3], square = 0.0f;
//@ if ORIGIN > 0 then
    from = 0.0f;
    for (int k = 0; k < DIMS; ++k) {
        way[k] = far_way(&w->item, box, k);
        float beyond = fmax(fabs(way[k]) - box[TREE_BOX_REACH + k], 0.0f);
        from = fma(beyond, beyond, from);
    }
    from *= 1.0f - OWN_SLACK;
//@ else
    for (int k = 0; k < DIMS; ++k)
        way[k] = w->point[k] - box[k];
//@ end
    for (int k = 0; k < DIMS; ++k) {
        float beyond = fmax(beyond_faces(w, box, way, k), 0.0f);
        square = fma(beyond, beyond, square);
    }
//@ if SHAPE >= 2 then
    float beyond_radius = fmax(root_of(square) - box[TREE_BOX_RADIUS], 0.0f);
    square = beyond_radius * beyond_radius;
//@ end
    square = fmax(square, from);
    bool is_kept = w->n < w->each || square < w->worst ||
                   (square == w->worst && id < w->hits[(size_t)(w->each - 1) * HIT_WORDS + 1]);
    if (is_kept)
        keep_hit(w, id, square);
    return false;
}

#endif

__kernel void point_query(POINT_QUERY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n); ++i) {
        uint at = in_order ? i : order[i];
        traversal w;
        for (int k = 0; k < 3; ++k)
            w.point[k] = items[(size_t)at * POINT_WORDS + k];
        if (point_is_bad(w.point)) {
            atomic_max(counters + BAD_LATEST, ~at);
            continue;
        }
//@ if ORIGIN > 0 then
        for (int k = 0; k < 3; ++k) {
            w.item.offset[k] = k < DIMS ? w.point[k] : 0.0f;
            w.item.cell[k] = k < DIMS ? as_int(items[(size_t)at * POINT_WORDS + 3 + k]) : 0;
            w.item.reach[k] = 0.0f;
        }
        far_item_bounds(&w.item, w.lower, w.upper);
//@ end
        w.boxes = boxes;
//@ if FILTERED == 1 then
        w.filter.of_objects = filters;
        w.filter.own = (uint2)(group, mask);
//@ end
        w.number = first_item + at;
        w.counters = counters;
#if WANTS == EVERY
        w.hits = hits;
        w.hits_capacity = hits_capacity;
        w.open = open;
        w.open_capacity = open_capacity;
#else
        w.hits = hits + (size_t)at * each * HIT_WORDS;
        w.each = each;
        w.n = 0;
        w.worst = INFINITY;
        for (uint k = 0; k < each; ++k) {
            w.hits[(size_t)k * HIT_WORDS] = w.number;
            w.hits[(size_t)k * HIT_WORDS + 1] = NO_OBJECT;
            w.hits[(size_t)k * HIT_WORDS + 2] = as_uint(INFINITY);
        }
#endif
        traverse_tree(&w, nodes, levels, n_levels);
    }
}
