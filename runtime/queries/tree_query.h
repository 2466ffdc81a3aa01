// SPDX-License-Identifier: MIT
// What queries of all kinds share: items of a caller (rays, boxes ...), divided between the
// devices, sent in chunks, each of which walks down its tree; hits that come back, and those
// that float leaves open, which the host decides.
#ifndef RUNTIME_TREE_QUERY_H
#define RUNTIME_TREE_QUERY_H

#include "runtime/queries/any_query.h"
#include "runtime/queries/query_hits.h"
#include "runtime/queries/tree.h"

enum { QUERY_SETTINGS = 6 };

typedef enum query_wants {
    QUERY_CLOSEST = DUET_QUERY_CLOSEST,
    QUERY_ANY = DUET_QUERY_ANY,
    QUERY_EVERY = DUET_QUERY_EVERY,
    QUERY_NEAREST // `each` hits an item, as the device has them
} query_wants;

typedef void query_normal(const duet_tree *tree, const void *item, const uint32_t *hit,
                          float normal[3]);

// A hit is an item's number, an object's id and, where there are more than two words, a value.
typedef struct query_kind {
    const char *item;   // "ray"
    const char *items;  // "rays"
    const char *wrong;  // mistakes in an item, for messages
    const char *kernel; // kernel of kernels/queries, and its entry
    uint32_t item_words;
    uint32_t item_cell; // in origin cells: the word of an item's cell
    uint32_t hit_words;
    // Copies items as the caller has them to items as the kernel does; NULL: they are that.
    void (*copy)(const duet_tree *tree, const void *items, uint64_t n, void *to);
    // Whether an item meets the object of a hit that float leaves open; exact. Its value, which is
    // never above the true one, may then be raised. NULL: float leaves nothing open.
    bool (*meets)(const duet_tree *tree, const void *item, uint32_t *hit);
    // Makes of a hit on an object, as the device wrote it, what the caller reads; NULL: it is that.
    void (*finish)(const duet_tree *tree, const void *item, uint32_t *hit);
    bool finish_reads; // the tree's objects
    // Computes the normal of a hit on an object; NULL: its hits have none.
    query_normal *normal;
    // Whether an item meets the tree's ground, and its hit's value; NULL: it finds no ground.
    bool (*meets_ground)(const struct tree_query *q, const void *item, uint32_t *hit);
    query_normal *ground_normal;
} query_kind;

// A kind for each shape of a tree, then that of large poses.
typedef query_kind query_kinds[DUET_SHAPES + 1];
extern const query_kinds ray_kinds, sweep_kinds, box_kinds, point_kinds;

#define QUERY_WORDS(type) (sizeof(type) / sizeof(uint32_t))

// A chunk on its way to a device with memory of its own, and back.
typedef struct query_flow {
    host_block staged; // items, to be sent
    host_block told;   // counters, then the first open hits
    buffer items, hits, open, counters;
    uint64_t first;
    cl_uint n;
    cl_event over; // event of its last command; the timeline's
} query_flow;

// One device's part of a run.
typedef struct query_side {
    const struct tree_query *query;
    tree_side *tree;
    kernel *kernel;
    buffer items, hits, open, counters;
    cl_uint n, first_item, hits_capacity, open_capacity; // the chunk launched last
    cl_uint n_levels, in_order, each;
    cl_uint group, mask;                                  // the query's filter
    buffer objects, boxes, nodes, levels, order, filters; // the tree's

    uint64_t first, last;
    hit_list found;
    hit_list open_hits;
    query_flow flows[2];  // two chunks that follow each other
    thread_pool *helpers; // copy items and finish hits; NULL: one thread does
    uint64_t undecided;
    double wall_ms;
} query_side;

typedef struct tree_query {
    const query_kind *kind;
    duet_tree *tree; // held
    char name[QUERY_NAME];
    query_wants wants;
    uint32_t each; // hits an item; 0 for QUERY_EVERY
    duet_level level;
    bool itself;               // its items are the tree's objects
    struct tree_query *own;    // of these, once a query of boxes is asked for them; else NULL
    const duet_filter *filter; // filter of the items, own_filter; NULL: they find every object
    duet_filter own_filter;
    gen_setting settings[QUERY_SETTINGS];
    uint32_t n_settings;
    query_side sides[2];
    const char *items;          // items of the run
    void *own_items;            // copies, of spheres and in origin cells: as the tree has them
    const duet_filter *filters; // the objects' filters, if objects are the items; NULL: all touch
    hit_list joined;
    query_normal *normal; // NULL: not asked for
    float *normals;       // [most_normals][3] of the hits, 0 where there is none
    uint64_t most_normals;
    uint32_t *on_ground; // [most_on_ground] a hit of each item: NO_OBJECT for none
    uint64_t most_on_ground;
    hit_list with_ground; // all hits, of every object
} tree_query;

// A query_result as a public query tells it, whose result and hits are of these types.
#define QUERY_RESULT(result_type, hit_type, found)                        \
    (result_type)                                                         \
    {                                                                     \
        .hits = (const hit_type *)(found).hits, .n_hits = (found).n_hits, \
        .undecided = (found).undecided, .total_ms = (found).total_ms,     \
        .device_ms = {                                                    \
            (found).device_ms[0],                                         \
            (found).device_ms[1],                                         \
        },                                                                \
    }

// Builds the kernel of the kind that the tree's shape has. BAD_ARGUMENT without a tree, and for a
// def that no query can have.
tree_query *tree_query_create(duet_tree *tree, const query_kinds kinds, const any_query_def *def,
                              duet_error *err);

// BAD_ARGUMENT unless the tree is in origin cells, or with far false is not.
bool tree_query_is_far(const tree_query *q, bool far, duet_error *err);

#endif
