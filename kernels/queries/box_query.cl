// SPDX-License-Identifier: MIT
// Which objects of a box tree (queries/tree.h) other boxes share a point with, as ACCURACY asks.
//
//   items    [n] poses or bounds, by SHAPE, as the tree's objects; with ITSELF these are meant, from
//            first_item on, each pair of them is found once, the lower id first, and only where
//   filters  of both, a group and a mask each, let them touch
//   order    [n] of items; in_order 1: as they come
//   objects, boxes, nodes    of the tree
//   levels   [n_levels] first node of each level, the lowest first
//   hits     [hits_capacity][2] an item's number and an object's id, in any order
//   open     [open_capacity][2] the same, of those that float leaves to the host
//
// Boxes that a traversal meets are kept until there are LANES of them, from whichever items.
#define HIT_WORDS 2

#if ITSELF
#define ITEMS objects
#define NUMBER(place, first_item) (place)
#else
#define ITEMS items
#define NUMBER(place, first_item) ((first_item) + (place))
#endif

typedef struct {
    __global const float *items;
    __global const float *objects;
    uint first_item;
    __global uint *hits;
    uint hits_capacity;
    __global uint *open;
    uint open_capacity;
    volatile __global uint *counters;
    uint n; // candidates
    uint places[LANES], ids[LANES];
} tester;

struct traversal {
    float lower[3], upper[3];
    __global const float *boxes;
    uint place;
#if ITSELF
    __global const uint2 *filters;
    uint2 filter;
#endif
//@ if FILTERED == 1 then
    filter filter;
//@ end
    tester *candidates;
};

static inline void list_hit(__global uint *row, uint item, uint id)
{
    if (!row)
        return;
    row[0] = item;
    row[1] = id;
}

static inline void test_candidates(tester *t)
{
    for (uint k = t->n; k < LANES; ++k) {
        t->places[k] = t->places[0];
        t->ids[k] = t->ids[0];
    }
    object a = object_at(t->items, t->places), b = object_at(t->objects, t->ids);
    uint answers[LANES];
    spread(answer_of(&a, &b), answers);
    for (uint k = 0; k < t->n; ++k) {
        uint item = NUMBER(t->places[k], t->first_item);
        if (answers[k] == COLLIDING)
            list_hit(add_row(t->hits, t->hits_capacity, t->counters + COUNT_HITS, HIT_WORDS), item, t->ids[k]);
        else if (answers[k] == UNDECIDED)
            list_hit(add_row(t->open, t->open_capacity, t->counters + COUNT_OPEN, HIT_WORDS), item, t->ids[k]);
    }
    t->n = 0;
}

static inline float farthest(const traversal *w)
{
    return INFINITY;
}

static inline row_mask meets_bounds(const traversal *w, __global const float *node, row *from)
{
    row_mask beside = (row_mask)(0);
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        row lower = load_row(node + k * TREE_WIDTH), upper = load_row(node + (3 + k) * TREE_WIDTH);
        beside |= (lower > (row)(w->upper[k])) | (upper < (row)(w->lower[k]));
    }
    *from = (row)(0.0f);
    return !beside;
}

static inline bool visit_box(traversal *w, uint slot, float from)
{
    tester *t = w->candidates;
    uint id = as_uint(w->boxes[(size_t)slot * TREE_BOX_WORDS + TREE_BOX_ID]);
#if ITSELF
    if (id <= w->place)
        return false;
    uint2 other = w->filters[id];
    if (!(other.x & w->filter.y) || !(w->filter.x & other.y))
        return false;
#endif
//@ if FILTERED == 1 then
    if (!can_touch(&w->filter, id))
        return false;
//@ end
    t->places[t->n] = w->place;
    t->ids[t->n++] = id;
    if (t->n == LANES)
        test_candidates(t);
    return false;
}

// The items' bounds, as numbers of each.
static inline void load_items(__global const float *items, const uint places[LANES], float lower[3][LANES],
                              float upper[3][LANES], uint refused[LANES])
{
    object o = object_at(items, places);
//@ if ORIGIN > 0 then
    bounds b = far_bounds(&o);
//@ else
    bounds b = object_bounds(&o);
//@ end
    spread(as_word(is_refused(&o)), refused);
    for (int k = 0; k < DIMS; ++k) {
#if LANES == 1
        lower[k][0] = b.lower[k];
        upper[k][0] = b.upper[k];
#else
        vstore8(b.lower[k], 0, lower[k]);
        vstore8(b.upper[k], 0, upper[k]);
#endif
    }
}

__kernel void box_query(BOX_QUERY_ARGS)
{
    tester t;
    t.items = ITEMS;
    t.objects = objects;
    t.first_item = first_item;
    t.hits = hits;
    t.hits_capacity = hits_capacity;
    t.open = open;
    t.open_capacity = open_capacity;
    t.counters = counters;
    t.n = 0;
    uint first = get_global_id(0) * PER_ITEM;
    for (uint from = first; from < min(first + PER_ITEM, n); from += LANES) {
        uint places[LANES], refused[LANES];
        float lower[3][LANES], upper[3][LANES];
        for (uint k = 0; k < LANES; ++k) {
            uint i = min(from + k, n - 1);
            places[k] = in_order ? i : order[i];
#if ITSELF
            places[k] += first_item;
#endif
        }
        load_items(ITEMS, places, lower, upper, refused);
        for (uint k = 0; k < LANES && from + k < n; ++k) {
            if (refused[k]) {
#if !ITSELF // no query finds it
                atomic_max(counters + BAD_LATEST, ~places[k]);
#endif
                continue;
            }
            traversal w;
            w.boxes = boxes;
            w.place = places[k];
#if ITSELF
            w.filters = filters;
            w.filter = filters[places[k]];
#endif
//@ if FILTERED == 1 then
            w.filter.of_objects = filters;
            w.filter.own = (uint2)(group, mask);
//@ end
            w.candidates = &t;
            for (int axis = 0; axis < DIMS; ++axis) {
                w.lower[axis] = lower[axis][k];
                w.upper[axis] = upper[axis][k];
            }
            traverse_tree(&w, nodes, levels, n_levels);
        }
    }
    if (t.n > 0)
        test_candidates(&t);
}
