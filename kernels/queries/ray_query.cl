// SPDX-License-Identifier: MIT
// Which boxes of a tree (queries/tree.h) rays meet, or with SWEPT boxes that move.
//
//   items    [n][ITEM_WORDS] rays: origin xyz, direction xyz, t_max; boxes that move: a pose
//            or bounds, by SHAPE, as the tree's objects, direction xyz, t_max
//            in origin cells a ray's cell follows its t_max, and a box's its pose
//   order    [n] of items, by where they begin; in_order 1: as they come
//   boxes, nodes    of the tree
//   levels   [n_levels] first node of each level, the lowest first
//   hits     [n][HIT_WORDS]; for all hits [hits_capacity][HIT_WORDS], in any order: the item,
//            the box's id, t; with SWEPT space for a normal
//   open     [open_capacity][HIT_WORDS] boxes that float leaves to the host, those that a
//            nearer hit makes needless left out
//
// The result does not depend on the tree. The distance to a box is never below
// that to its bounds, and the distance to bounds never below that to wider ones: each
// operation on the way is monotone. So a node that is passed over for being further away
// than the nearest hit holds nothing nearer.
#define CLOSEST 0
#define ANY 1
#define EVERY 2

//@ if ORIGIN > 0 then
#define ITEM_WORDS (SWEPT ? OBJECT_WIDTH + 4 : 10)
#define LINE_WORD (SWEPT ? OBJECT_WIDTH - 1 : 3)
//@ else
#define ITEM_WORDS (SWEPT ? OBJECT_WIDTH + 4 : 7)
//@ end
#define HIT_WORDS (SWEPT ? 6 : 3)

#define SLACK (64.0f * 0x1p-24f) // of a box's size, as seen from the ray's origin
#define GREATEST_SIZE 0x1p110f

struct traversal {
    line l;
//@ if ORIGIN > 0 then
    far_item item;
//@ end
//@ if SHAPE >= 2 and SWEPT == 1 then
    mover m;
//@ else
#if SWEPT && !SHAPE
    mover m;
#endif
//@ end
    __global const float *boxes;
//@ if FILTERED == 1 then
    filter filter;
//@ end
    uint number;
    float best; // CLOSEST: t and id of the nearest hit so far
    uint id;
#if WANTS == EVERY
    __global uint *hits;
    uint hits_capacity;
#endif
    __global uint *open;
    uint open_capacity;
    volatile __global uint *counters;
};

static inline row_mask meets_bounds(const traversal *w, __global const float *node, row *from)
{
    return line_meets_nodes(&w->l, node, from);
}

// ------------------------------------------------------------ a box

//@ if SHAPE >= 2 then
static inline uint meet_box(const traversal *w, __global const float *box, float *t)
{
//@ if SWEPT == 1 then
    return mover_meets(&w->m, &w->l, box, t);
//@ else
    return line_meets_rounded(&w->l, box, t);
//@ end
}
//@ else
#if SHAPE

static inline uint meet_box(const traversal *w, __global const float *box, float *t)
{
    return line_meets_bounds(&w->l, box, t);
}

#elif SWEPT

static inline uint meet_box(const traversal *w, __global const float *box, float *t)
{
//@ if ORIGIN > 0 then
    return mover_meets(&w->m, &w->item, &w->l, box, t);
//@ else
    return mover_meets(&w->m, &w->l, box, t);
//@ end
}

#else

static inline float along(const float *axis, const float v[3])
{
#if DIMS == 3
    return fma(axis[0], v[0], fma(axis[1], v[1], axis[2] * v[2]));
#else
    return fma(axis[0], v[0], axis[1] * v[1]);
#endif
}

// Finds where the ray is between the two faces of each edge, widened and narrowed by what
// float may be wrong by. `t` is at least that of the box's bounds.
static inline uint meet_box(const traversal *w, __global const float *row_of_box, float *t)
{
    const line *r = &w->l;
    float box[TREE_BOX_WORDS], way[3], size = 0.0f;
#pragma unroll
    for (int k = 0; k < TREE_BOX_WORDS / 4; ++k)
        vstore4(((__global const float4 *)row_of_box)[k], k, box);
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
//@ if ORIGIN > 0 then
        way[k] = far_way(&w->item, row_of_box, k);
//@ else
        way[k] = r->lower[k] - box[k];
//@ end
        size += fabs(way[k]) + box[3 + k];
    }
    if (!(size >= LEAST_SIZE && size <= GREATEST_SIZE))
        return OPEN;
    float doubt = SLACK * size;
    float enter = *t, surely_enter = 0.0f, maybe_enter = 0.0f;
    float surely_leave = r->t_max, maybe_leave = r->t_max;
    bool open = false;
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        float at = along(box + TREE_BOX_AXES + 3 * k, way), half_extent = box[3 + k];
        float speed = along(box + TREE_BOX_AXES + 3 * k, r->direction);
        if (fabs(speed) < SLOW) {
            if (fabs(at) > half_extent + doubt)
                return MISSED;
            open = open || fabs(at) > half_extent - doubt;
            continue;
        }
        float inverse = inverse_of(fabs(speed));
        at = speed > 0.0f ? at : -at;
        float in = (-half_extent - at) * inverse, out = (half_extent - at) * inverse, error = doubt * inverse;
        enter = fmax(enter, in);
        surely_enter = fmax(surely_enter, in + error);
        maybe_enter = fmax(maybe_enter, in - error);
        surely_leave = fmin(surely_leave, out - error);
        maybe_leave = fmin(maybe_leave, out + error);
    }
    if (maybe_enter > maybe_leave)
        return MISSED;
    *t = fmin(enter, r->t_max);
    return !open && surely_enter <= surely_leave ? MET : OPEN;
}

#endif
//@ end

//@ if ORIGIN > 0 then
// Returns where the line enters the box's own bounds, or a place before.
static inline float enter_own_bounds(const traversal *w, __global const float *box)
{
    float enter = 0.0f;
    for (int k = 0; k < DIMS; ++k) {
        float inverse = w->l.inverse[k];
        if (!(fabs(inverse) > 0.0f))
            continue;
        float way = far_way(&w->item, box, k), reach = w->item.reach[k] + box[TREE_BOX_REACH + k];
        float in = inverse > 0.0f ? -way - reach : reach - way;
        enter = fmax(enter, in * (inverse * (1.0f - OWN_SLACK)));
    }
    return fmin(enter, w->l.t_max);
}

//@ end
// ------------------------------------------------------------ the traversal

static inline float farthest(const traversal *w)
{
    return w->best;
}

static inline void list_hit(const traversal *w, __global uint *row, uint id, float t)
{
    if (!row)
        return;
    row[0] = w->number;
    row[1] = id;
    row[2] = as_uint(t * w->l.scale);
    for (int k = 3; k < HIT_WORDS; ++k)
        row[k] = 0;
}

static inline bool visit_box(traversal *w, uint slot, float from)
{
    __global const float *box = w->boxes + (size_t)slot * TREE_BOX_WORDS;
//@ if FILTERED == 1 then
    if (!can_touch(&w->filter, as_uint(box[TREE_BOX_ID])))
        return false;
//@ end
//@ if ORIGIN > 0 then
    float t = enter_own_bounds(w, box);
//@ else
    float t = from;
//@ end
    uint id = as_uint(box[TREE_BOX_ID]);
    uint found = meet_box(w, box, &t);
    bool needless = WANTS == CLOSEST && (t > w->best || (t == w->best && id > w->id));
    if (found == MISSED || needless)
        return false;
    if (found == OPEN) {
        list_hit(w, add_row(w->open, w->open_capacity, w->counters + COUNT_OPEN, HIT_WORDS), id, t);
        return false;
    }
#if WANTS == EVERY
    list_hit(w, add_row(w->hits, w->hits_capacity, w->counters + COUNT_HITS, HIT_WORDS), id, t);
#endif
    w->best = WANTS == EVERY ? INFINITY : t;
    w->id = id;
    return WANTS == ANY;
}

// Whether the row is an item at all.
static inline bool load_item(traversal *w, __global const float *row)
{
    float lower[3], upper[3];
#if SWEPT
    const uint same[LANES] = {0};
    object o = object_at(row, same);
    bounds b = object_bounds(&o);
    uint refused[LANES];
    spread(as_word(is_refused(&o)), refused);
//@ if ORIGIN > 0 then
    real reach[3];
    set_reach(reach, &o);
    for (int k = 0; k < 3; ++k) {
        w->item.offset[k] = FIRST_LANE(o.centre[k]);
        w->item.cell[k] = FIRST_LANE(o.cell[k]);
        w->item.reach[k] = k < DIMS ? FIRST_LANE(reach[k]) : 0.0f;
    }
//@ else
    for (int k = 0; k < 3; ++k) {
        lower[k] = FIRST_LANE(b.lower[k]);
        upper[k] = FIRST_LANE(b.upper[k]);
    }
//@ end
//@ if SHAPE >= 2 and SWEPT == 1 then
    set_mover(&w->m, &o);
//@ else
#if !SHAPE
    set_mover(&w->m, &o);
#endif
//@ end
    if (refused[0])
        return false;
#else
    for (int k = 0; k < DIMS; ++k)
        if (!(fabs(row[k]) <= MOST_COORDINATE))
            return false;
//@ if ORIGIN > 0 then
    for (int k = 0; k < 3; ++k) {
        w->item.offset[k] = k < DIMS ? row[k] : 0.0f;
        w->item.cell[k] = k < DIMS ? as_int(row[7 + k]) : 0;
        w->item.reach[k] = 0.0f;
    }
//@ else
    for (int k = 0; k < 3; ++k)
        lower[k] = upper[k] = row[k];
//@ end
#endif
//@ if ORIGIN > 0 then
    far_item_bounds(&w->item, lower, upper);
    if (line_is_bad(row + LINE_WORD))
        return false;
    set_line(&w->l, lower, upper, row + LINE_WORD);
//@ else
    if (line_is_bad(row + ITEM_WORDS - 4))
        return false;
    set_line(&w->l, lower, upper, row + ITEM_WORDS - 4);
//@ end
    return true;
}

__kernel void ray_query(RAY_QUERY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n); ++i) {
        uint at = in_order ? i : order[i];
        traversal w;
        w.boxes = boxes;
//@ if FILTERED == 1 then
        w.filter.of_objects = filters;
        w.filter.own = (uint2)(group, mask);
//@ end
        w.number = first_item + at;
        w.best = INFINITY;
        w.id = NO_OBJECT;
        w.open = open;
        w.open_capacity = open_capacity;
        w.counters = counters;
#if WANTS == EVERY
        w.hits = hits;
        w.hits_capacity = hits_capacity;
#endif
        if (!load_item(&w, items + (size_t)at * ITEM_WORDS)) {
            atomic_max(counters + BAD_LATEST, ~at);
            continue;
        }
        traverse_tree(&w, nodes, levels, n_levels);
#if WANTS != EVERY
        list_hit(&w, hits + (size_t)at * HIT_WORDS, WANTS == ANY && w.id != NO_OBJECT ? 0 : w.id,
                 WANTS == ANY ? 0.0f : w.best);
#endif
    }
}
