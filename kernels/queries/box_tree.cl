// SPDX-License-Identifier: MIT
// A tree over boxes, for queries.
//
//   objects [n] poses or bounds, by SHAPE; those that are refused are left out
//   extent  [EXTENT_WORDS] what a sample of them extends over
//   keys    [n, and 7 more] where each box comes in the tree: large ones first, those of
//                           one size class along a curve
//   ids     [n] sorted by their keys
//   boxes   [slots][TREE_BOX_WORDS] in that order; slots is n rounded up to TREE_WIDTH
//   nodes   [..][NODE_WORDS] the lowest level first, the root last
//   items   [first_item + n][item_words], each begins with a point
//
// A key decides only how good the tree is, never what a query finds.
#define CLASSES 16
#define BITS (DIMS == 3 ? 9 : 14) // that a cell's number has along an axis

// As sortable_word, of each lane.
static inline word rising(real x)
{
    word bits = as_word(x);
    return bits ^ (((word)(0) - (bits >> 31)) | 0x80000000u);
}

// Keys are made with these; without any object of the sample cells are NaN or 0, and all is in the first.
typedef struct {
    float lower[3], per_cell[3];
    float widest; // half of the widest edge
} curve;

static inline curve load_curve(__global const uint *extent)
{
    curve c;
    for (int k = 0; k < 3; ++k) {
        float upper = number_of(extent[k]);
        c.lower[k] = -number_of(extent[3 + k]);
        float edge = upper - c.lower[k];
        c.per_cell[k] = edge > 0x1p-100f ? (float)(1 << BITS) * inverse_of(edge) : 0.0f;
    }
    c.widest = number_of(extent[6]);
    return c;
}

// The place along Hilbert's curve of the cell that a point is in. The cells' numbers are
// turned and mirrored bit by bit, as the curve is from one square to the next smaller one
// (Skilling 2004, "Programming the Hilbert curve").
static inline word curve_place(const real point[3], const curve *c)
{
    word cell[3];
    for (int k = 0; k < DIMS; ++k) {
        real at = (point[k] - c->lower[k]) * c->per_cell[k];
        at = select(ALL(0.0f), at, at > ALL(0.0f));
        cell[k] = to_word(fmin(at, ALL((float)((1 << BITS) - 1))));
    }
    for (uint bit = 1u << (BITS - 1); bit > 1; bit >>= 1)
        for (int k = 0; k < DIMS; ++k) {
            word mirrored = (word)(0) - ((cell[k] & bit) / bit);
            word swapped = (cell[0] ^ cell[k]) & (bit - 1) & ~mirrored;
            cell[0] ^= swapped | (mirrored & (bit - 1));
            cell[k] ^= swapped;
        }
    for (int k = 1; k < DIMS; ++k)
        cell[k] ^= cell[k - 1];
    word turn = (word)(0);
    for (uint bit = 1u << (BITS - 1); bit > 1; bit >>= 1)
        turn ^= ((word)(0) - ((cell[DIMS - 1] & bit) / bit)) & (bit - 1);
    word place = (word)(0);
    for (int bit = BITS - 1; bit >= 0; --bit)
        for (int k = 0; k < DIMS; ++k)
            place = place << 1 | ((cell[k] ^ turn) >> bit & 1);
    return place;
}

static inline real greatest_of(const real v[3])
{
    return fmax(fmax(v[0], v[1]), v[2]);
}

// Half of the widest edge.
static inline real object_half(const object *o)
{
#if SHAPE == SHAPE_POSES
//@ if SHAPE >= 2 then
    return greatest_of(o->halves) + o->radius;
//@ else
    return greatest_of(o->halves);
//@ end
#else
    real halves[3];
    for (int k = 0; k < 3; ++k)
        halves[k] = o->upper[k] * 0.5f - o->lower[k] * 0.5f;
    return greatest_of(halves);
#endif
}

// Sizes that differ by less than a factor of two are of a class, or neighbours.
static inline word size_class(const object *o, float widest)
{
    word exponent = as_word(object_half(o)) >> 23;
    word most = (word)(as_uint(widest) >> 23);
    return min(most - min(most, exponent), (word)(CLASSES - 1));
}

// Takes n objects, `step` apart. It decides how good the tree is and nothing else.
__kernel void tree_extent(TREE_EXTENT_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    word greatest[EXTENT_WORDS];
    for (int i = 0; i < EXTENT_WORDS; ++i)
        greatest[i] = (word)(0);
    for (uint from = first; from < min(first + PER_ITEM, n); from += LANES) {
        uint ids[LANES];
        for (uint k = 0; k < LANES; ++k)
            ids[k] = min(from + k, n - 1) * step;
        object o = object_at(objects, ids);
        mask refused = is_refused(&o);
        real point[3];
//@ if ORIGIN > 0 then
        far_point(&o, point);
//@ else
        object_point(&o, point);
//@ end
        for (int i = 0; i < EXTENT_WORDS; ++i) {
            word at = rising(i < 3 ? point[i] : i < 6 ? -point[i - 3] : object_half(&o));
            greatest[i] = max(greatest[i], select(at, (word)(0), as_word(refused)));
        }
    }
    for (int i = 0; i < EXTENT_WORDS; ++i) {
        uint each[LANES];
        spread(greatest[i], each);
        for (uint k = 0; k < LANES; ++k)
            atomic_max(extent + i, each[k]);
    }
}

__kernel void tree_keys(TREE_KEYS_ARGS)
{
    curve c = load_curve(extent);
    uint first = get_global_id(0) * PER_ITEM;
    for (uint from = first; from < min(first + PER_ITEM, n); from += LANES) {
        uint ids[LANES], key[LANES], refused[LANES];
        for (uint k = 0; k < LANES; ++k)
            ids[k] = min(from + k, n - 1);
        object o = object_at(objects, ids);
        real point[3];
//@ if ORIGIN > 0 then
        far_point(&o, point);
//@ else
        object_point(&o, point);
//@ end
        word place = curve_place(point, &c);
        spread(size_class(&o, c.widest) << (DIMS * BITS) | place, key);
        spread(as_word(is_refused(&o)), refused);
        for (uint k = 0; k < LANES && from + k < n; ++k) {
            keys[from + k] = key[k];
            if (refused[k]) {
                atomic_max(counters + BAD_LATEST, ~(from + k));
                atomic_inc(counters + COUNT_BAD);
            }
        }
    }
}

// The rows of boxes as the tree keeps them, but for their ids.
static inline void set_leaf(const object *o, real row[TREE_BOX_WORDS])
{
#if SHAPE == SHAPE_POSES
    real axis[3][3];
    set_axes(axis, o->rotation);
    for (int k = 0; k < 3; ++k) {
        row[k] = o->centre[k];
        row[3 + k] = o->halves[k];
    }
    for (int k = 0; k < 9; ++k)
        row[TREE_BOX_AXES + k] = axis[k / 3][k % 3];
//@ if SHAPE >= 2 then
    row[TREE_BOX_RADIUS] = o->radius;
    for (int k = TREE_BOX_RADIUS + 1; k < TREE_BOX_ID; ++k)
        row[k] = ALL(0.0f);
//@ elseif ORIGIN > 0 then
    real reach[3];
    set_reach(reach, o);
    for (int k = TREE_BOX_CELL; k < TREE_BOX_ID; ++k)
        row[k] = ALL(0.0f);
    for (int k = 0; k < DIMS; ++k) {
        row[TREE_BOX_CELL + k] = as_real(o->cell[k]);
        row[TREE_BOX_REACH + k] = reach[k];
    }
//@ end
#else
    for (int k = 0; k < 3; ++k) {
        row[k] = o->lower[k];
        row[3 + k] = o->upper[k];
    }
    row[6] = ALL(0.0f);
#endif
}

// Stores bounds as children of nodes, from one of LANES children on.
static inline void store_child_bounds(__global float *node, const bounds *b)
{
    for (int k = 0; k < DIMS; ++k) {
#if LANES == 1
        node[k * TREE_WIDTH] = b->lower[k];
        node[(3 + k) * TREE_WIDTH] = b->upper[k];
#else
        vstore8(b->lower[k], 0, node + k * TREE_WIDTH);
        vstore8(b->upper[k], 0, node + (3 + k) * TREE_WIDTH);
#endif
    }
}

static inline word word_of(const uint from[LANES])
{
#if LANES == 1
    return from[0];
#else
    return vload8(0, from);
#endif
}

__kernel void tree_leaves(TREE_LEAVES_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint from = first; from < min(first + PER_ITEM, slots); from += LANES) {
        uint places[LANES], names[LANES], missing[LANES];
        for (uint k = 0; k < LANES; ++k) {
            places[k] = from + k;
            names[k] = ids[min(from + k, n - 1)];
            missing[k] = from + k < n ? 0 : ~0u;
        }
        object o = object_at(objects, names);
//@ if ORIGIN > 0 then
        bounds b = far_bounds(&o);
//@ else
        bounds b = object_bounds(&o);
//@ end
        clear_bounds(&b, is_refused(&o) | as_whole(word_of(missing)));
        store_child_bounds(nodes + (size_t)(from / TREE_WIDTH) * NODE_WORDS + from % TREE_WIDTH, &b);
        real row[TREE_BOX_WORDS];
        set_leaf(&o, row);
        row[TREE_BOX_ID] = as_real(word_of(names));
        for (int k = 0; k < TREE_BOX_WORDS; k += 8)
            store_eight(boxes, places, TREE_BOX_WORDS, k, row + k, (word)(1));
    }
}

// Items that begin near each other visit the same nodes.
__kernel void item_keys(ITEM_KEYS_ARGS)
{
    curve c = load_curve(extent);
    uint first = get_global_id(0) * PER_ITEM;
    for (uint from = first; from < min(first + PER_ITEM, n); from += LANES) {
        uint key[LANES];
        float begin[3][LANES];
        for (uint k = 0; k < LANES; ++k)
            for (int i = 0; i < 3; ++i)
                begin[i][k] = items[((size_t)first_item + min(from + k, n - 1)) * item_words + i];
        real point[3];
        for (int i = 0; i < 3; ++i)
#if LANES == 1
            point[i] = begin[i][0];
#else
            point[i] = vload8(0, begin[i]);
#endif
//@ if ORIGIN > 0 then
        int cell[3][LANES];
        for (uint k = 0; k < LANES; ++k)
            for (int i = 0; i < 3; ++i)
                cell[i][k] = as_int(items[((size_t)first_item + min(from + k, n - 1)) * item_words + item_cell + i]);
        for (int i = 0; i < 3; ++i)
#if LANES == 1
            point[i] = far_along(cell[i][0], point[i]);
#else
            point[i] = far_along(vload8(0, cell[i]), point[i]);
#endif
//@ end
        spread(curve_place(point, &c) >> (DIMS * BITS - ITEM_BITS), key);
        for (uint k = 0; k < LANES && from + k < n; ++k)
            keys[from + k] = key[k];
    }
}

static inline float least_of(float8 v)
{
    float4 four = fmin(v.lo, v.hi);
    float2 two = fmin(four.lo, four.hi);
    return fmin(two.x, two.y);
}

// Nodes of a level from the n_below ones that begin at `below`.
__kernel void tree_level(TREE_LEVEL_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n_slots); ++i) {
        __global const float *from = nodes + (size_t)(below + min(i, n_below - 1)) * NODE_WORDS;
        __global float *to = nodes + (size_t)(at + i / TREE_WIDTH) * NODE_WORDS + i % TREE_WIDTH;
        for (int k = 0; k < DIMS; ++k) {
            float least = least_of(vload8(0, from + k * TREE_WIDTH));
            float greatest = -least_of(-vload8(0, from + (3 + k) * TREE_WIDTH));
            to[k * TREE_WIDTH] = i < n_below ? least : INFINITY;
            to[(3 + k) * TREE_WIDTH] = i < n_below ? greatest : -INFINITY;
        }
    }
}
