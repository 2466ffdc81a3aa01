// SPDX-License-Identifier: MIT
#include "runtime/queries/box_tree.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

static const binding tree_bindings[] = {BIND_BUFFER(box_tree, "objects", "float *", objects),
                                        BIND_BUFFER(box_tree, "items", "float *", items),
                                        BIND_BUFFER(box_tree, "keys", "uint *", keys),
                                        BIND_BUFFER(box_tree, "ids", "uint *", ids),
                                        BIND_BUFFER(box_tree, "boxes", "float *", boxes),
                                        BIND_BUFFER(box_tree, "nodes", "float *", nodes),
                                        BIND_BUFFER(box_tree, "extent", "uint *", extent),
                                        BIND_BUFFER(box_tree, "counters", "uint *", counters),
                                        BIND_VALUE(box_tree, "n", n_listed),
                                        BIND_VALUE(box_tree, "step", step),
                                        BIND_VALUE(box_tree, "first_item", first_item),
                                        BIND_VALUE(box_tree, "item_words", item_words),
                                        BIND_VALUE(box_tree, "item_cell", item_cell),
                                        BIND_VALUE(box_tree, "slots", slots),
                                        BIND_VALUE(box_tree, "below", below),
                                        BIND_VALUE(box_tree, "n_below", n_below),
                                        BIND_VALUE(box_tree, "at", at),
                                        BIND_VALUE(box_tree, "n_slots", n_slots),
                                        {0}};

duet_shape box_tree_shape(duet_shape shape)
{
    return shape == DUET_SHAPE_SPHERES ? DUET_SHAPE_ROUNDED_BOXES : shape;
}

size_t box_tree_width(duet_shape shape, float origin)
{
    return origin_row_bytes(box_tree_shape(shape), origin);
}

bool box_tree_open(box_tree *t, const device *d, program_set *programs, uint32_t dims,
                   duet_shape shape, float origin, duet_error *err)
{
    *t = (box_tree){.device = d,
                    .dims = dims,
                    .shape = shape,
                    .origin = origin,
                    .scan = {.device = d},
                    .radix = {.device = d, .scan = &t->scan}};
    const gen_offer offers[] = {{"box_tree", "DIMS", dims, GEN_REQUIRED, NULL},
                                {"box_tree", "SHAPE", box_tree_shape(shape), GEN_REQUIRED, NULL},
                                {"box_tree", "ORIGIN", origin_setting(origin), GEN_REQUIRED, NULL}};
    const kernel_request list[] = {{&t->measure, true, "box_tree", "tree_extent", tree_bindings},
                                   {&t->key, true, "box_tree", "tree_keys", tree_bindings},
                                   {&t->leaves, true, "box_tree", "tree_leaves", tree_bindings},
                                   {&t->level, true, "box_tree", "tree_level", tree_bindings},
                                   {&t->item_key, true, "box_tree", "item_keys", tree_bindings},
                                   SCAN_KERNELS(&t->scan, true),
                                   RADIX_SORT_KERNELS(&t->radix, true)};
    return program_set_kernels(programs, list, sizeof list / sizeof *list, offers,
                               sizeof offers / sizeof *offers, err);
}

void box_tree_close(box_tree *t)
{
    buffer *const all[] = {&t->objects, &t->keys,  &t->ids,    &t->keys_spare, &t->ids_spare,
                           &t->boxes,   &t->nodes, &t->levels, &t->extent,     &t->counters};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        buffer_release(all[i]);
    radix_sort_close(&t->radix);
    scan_close(&t->scan);
    *t = (box_tree){0};
}

// ---------------------------------------------------------------- building

static uint32_t nodes_for(uint32_t n)
{
    return n / TREE_WIDTH + (n % TREE_WIDTH != 0);
}

// First node of each level, the lowest first. Returns how many nodes there are.
static uint32_t plan_levels(box_tree *t, cl_uint first[TREE_LEVELS + 1])
{
    uint32_t n_nodes = 0;
    uint32_t n = t->n;
    t->n_levels = 0;
    while (n > 1 || (n == 1 && t->n_levels == 0)) {
        n = nodes_for(n);
        first[t->n_levels++] = n_nodes;
        n_nodes += n;
    }
    return n_nodes;
}

static bool reserve_lists(box_tree *t, uint32_t n, duet_error *err)
{
    size_t bytes = ((size_t)n + TREE_WIDTH) * sizeof(cl_uint);
    return buffer_reserve(&t->keys, t->device, bytes, err) &&
           buffer_reserve(&t->ids, t->device, bytes, err) &&
           buffer_reserve(&t->keys_spare, t->device, bytes, err) &&
           buffer_reserve(&t->ids_spare, t->device, bytes, err);
}

static bool reserve(box_tree *t, uint32_t n_nodes, duet_error *err)
{
    uint32_t box_words = box_tree_shape(t->shape) == DUET_SHAPE_ROUNDED_BOXES ? TREE_ROUNDED_WORDS
                         : t->origin > 0.0f                                   ? TREE_FAR_WORDS
                                            : TREE_BOX_WORDS_OF(t->shape == DUET_SHAPE_BOUNDS);
    size_t boxes = (size_t)t->slots * box_words * sizeof(cl_float);
    size_t nodes = (size_t)n_nodes * NODE_WORDS * sizeof(cl_float);
    return reserve_lists(t, t->n, err) && buffer_reserve(&t->boxes, t->device, boxes, err) &&
           buffer_reserve(&t->nodes, t->device, nodes, err) &&
           buffer_reserve(&t->levels, t->device, TREE_LEVELS * sizeof(cl_uint), err) &&
           buffer_reserve(&t->extent, t->device, EXTENT_WORDS * sizeof(cl_uint), err) &&
           buffer_reserve(&t->counters, t->device, QUERY_COUNTERS * sizeof(cl_uint), err);
}

static bool sort_keys(box_tree *t, timeline *times, uint32_t n, uint32_t bits, duet_error *err)
{
    const radix_lists lists = {&t->keys, &t->ids, &t->keys_spare, &t->ids_spare};
    return radix_sort_run(&t->radix, times, "sort", &lists, n, bits, err);
}

// Measures a sample.
static bool measure(box_tree *t, timeline *times, duet_error *err)
{
    enum { SAMPLE = 1 << 13 };
    t->step = t->n / SAMPLE + 1;
    t->n_listed = t->n / t->step + (t->n % t->step != 0);
    bool ok = timeline_fill(times, "clear", &t->extent, 0, 0, EXTENT_WORDS, err) &&
              timeline_launch(times, "keys", t->measure, t->n_listed, t, err);
    t->n_listed = t->n;
    return ok;
}

static bool sort_boxes(box_tree *t, timeline *times, duet_error *err)
{
    return timeline_fill(times, "clear", &t->counters, 0, 0, QUERY_COUNTERS, err) &&
           timeline_launch(times, "keys", t->key, t->n, t, err) &&
           sort_keys(t, times, t->n, 32, err);
}

static bool check_objects(box_tree *t, timeline *times, uint32_t n_hidden, duet_error *err)
{
    cl_uint counters[QUERY_COUNTERS];
    if (!timeline_read(times, "check", &t->counters, counters, sizeof counters, err))
        return false;
    if (counters[COUNT_BAD] == n_hidden)
        return true;
    if (n_hidden > 0)
        return error_set(err, DUET_STATUS_BAD_OBJECT,
                         "%u bodies of %u are at no finite place, or above 2^100",
                         counters[COUNT_BAD] - n_hidden, t->n - n_hidden);
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %u is not a number, infinite, %s, or above "
                     "2^100",
                     ~counters[BAD_LATEST],
                     t->shape == DUET_SHAPE_BOUNDS ? "with a lower corner above its upper one"
                     : t->origin > 0.0f ? "negative, without rotation, 2^30 origin cells from 0"
                                        : "negative, without rotation");
}

static bool make_levels(box_tree *t, timeline *times, const cl_uint *first, uint32_t n_nodes,
                        duet_error *err)
{
    bool ok = timeline_launch(times, "nodes", t->leaves, t->slots, t, err);
    for (uint32_t level = 1; ok && level < t->n_levels; ++level) {
        uint32_t end = level + 1 < t->n_levels ? first[level + 1] : n_nodes;
        t->below = first[level - 1];
        t->n_below = first[level] - first[level - 1];
        t->at = first[level];
        t->n_slots = (end - first[level]) * TREE_WIDTH;
        ok = timeline_launch(times, "nodes", t->level, t->n_slots, t, err);
    }
    return ok;
}

bool box_tree_hold(box_tree *t, const device *d, void *objects, uint32_t n, duet_error *err)
{
    size_t width = box_tree_width(t->shape, t->origin);
    return n > 0 ? buffer_hold(&t->objects, d, objects, n * width, err)
                 : buffer_reserve(&t->objects, d, width, err);
}

bool box_tree_build(box_tree *t, timeline *times, uint32_t n, uint32_t n_hidden, duet_error *err)
{
    cl_uint first[TREE_LEVELS + 1] = {0};
    t->n = n;
    t->slots = nodes_for(n) * TREE_WIDTH;
    uint32_t n_nodes = plan_levels(t, first);
    return reserve(t, n_nodes, err) && measure(t, times, err) &&
           (n == 0 ||
            (sort_boxes(t, times, err) &&
             timeline_write(times, "send objects", &t->levels, first, TREE_LEVELS * sizeof *first,
                            err) &&
             make_levels(t, times, first, n_nodes, err) && check_objects(t, times, n_hidden, err)));
}

void box_tree_forget_objects(box_tree *t)
{
    if (t->objects.borrowed)
        buffer_release(&t->objects);
}

bool box_tree_order(box_tree *t, timeline *times, const buffer *items, uint32_t item_words,
                    uint32_t item_cell, uint32_t first, uint32_t n, duet_error *err)
{
    t->items = *items;
    t->first_item = first;
    t->item_words = item_words;
    t->item_cell = item_cell;
    t->n_listed = n;
    return reserve_lists(t, n, err) && timeline_launch(times, "keys", t->item_key, n, t, err) &&
           sort_keys(t, times, n, (uint32_t)kernel_param(t->item_key, "ITEM_BITS"), err);
}
