// SPDX-License-Identifier: MIT
#include "runtime/queries/box_tree.h"

#include "base/error.h"

#include <math.h>

enum { MOST_BOXES = 1 << 30 };

static const binding tree_bindings[] = {BIND_BUFFER(box_tree, "objects", "float *", objects),
                                        BIND_BUFFER(box_tree, "rays", "float *", rays),
                                        BIND_BUFFER(box_tree, "keys", "uint *", keys),
                                        BIND_BUFFER(box_tree, "ids", "uint *", ids),
                                        BIND_BUFFER(box_tree, "boxes", "float *", boxes),
                                        BIND_BUFFER(box_tree, "nodes", "float *", nodes),
                                        BIND_BUFFER(box_tree, "counters", "uint *", counters),
                                        BIND_VALUE(box_tree, "n", n),
                                        BIND_VALUE(box_tree, "slots", slots),
                                        BIND_VALUE(box_tree, "lower", lower),
                                        BIND_VALUE(box_tree, "per_cell", per_cell),
                                        BIND_VALUE(box_tree, "below", below),
                                        BIND_VALUE(box_tree, "n_below", n_below),
                                        BIND_VALUE(box_tree, "at", at),
                                        BIND_VALUE(box_tree, "n_slots", n_slots),
                                        {0}};

static kernel *ask(program_set *programs, const char *entry, uint32_t dims, duet_error *err)
{
    const gen_setting settings[] = {{"DIMS", dims}};
    return program_set_kernel(programs, "box_tree", entry, settings, 1, tree_bindings, err);
}

bool box_tree_open(box_tree *t, const device *d, program_set *programs, uint32_t dims,
                   duet_error *err)
{
    *t = (box_tree){.device = d};
    t->key = ask(programs, "tree_keys", dims, err);
    t->leaves = t->key ? ask(programs, "tree_leaves", dims, err) : NULL;
    t->level = t->leaves ? ask(programs, "tree_level", dims, err) : NULL;
    t->ray_key = t->level ? ask(programs, "ray_keys", dims, err) : NULL;
    return t->ray_key && scan_open(&t->scan, d, programs, NULL, 0, err) &&
           radix_sort_open(&t->radix, d, programs, &t->scan, NULL, 0, err);
}

void box_tree_close(box_tree *t)
{
    buffer *const all[] = {&t->objects, &t->keys,  &t->ids,    &t->keys_spare, &t->ids_spare,
                           &t->boxes,   &t->nodes, &t->levels, &t->counters};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        buffer_release(all[i]);
    radix_sort_close(&t->radix);
    scan_close(&t->scan);
    *t = (box_tree){0};
}

// ---------------------------------------------------------------- the curve

// Where the boxes are and how wide they get, from a sample: it decides how good the tree
// is and nothing else.
static void fit_curve(box_tree *t, const duet_pose *poses, uint32_t n, uint32_t dims)
{
    enum { SAMPLE = 1 << 16 };
    const float cells = dims == 3 ? 512 : 16384;
    float lower[3] = {INFINITY, INFINITY, INFINITY};
    float upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    float widest = 0;
    uint32_t step = n / SAMPLE + 1;
    for (uint32_t i = 0; i < n; i += step)
        for (uint32_t k = 0; k < dims; ++k) {
            lower[k] = fminf(lower[k], poses[i].centre[k]);
            upper[k] = fmaxf(upper[k], poses[i].centre[k]);
            widest = fmaxf(widest, poses[i].half_extents[k]);
        }
    for (uint32_t k = 0; k < 3; ++k) {
        float edge = upper[k] - lower[k];
        t->lower.s[k] = isfinite(lower[k]) ? lower[k] : 0;
        t->per_cell.s[k] = edge > 0x1p-100f && isfinite(edge) ? cells / edge : 0;
    }
    t->lower.s[3] = isfinite(widest) ? widest : 0;
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
    do {
        n = nodes_for(n);
        first[t->n_levels++] = n_nodes;
        n_nodes += n;
    } while (n > 1);
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
    size_t boxes = (size_t)t->slots * TREE_BOX_WORDS * sizeof(cl_float);
    size_t nodes = (size_t)n_nodes * NODE_WORDS * sizeof(cl_float);
    return reserve_lists(t, t->n, err) && buffer_reserve(&t->boxes, t->device, boxes, err) &&
           buffer_reserve(&t->nodes, t->device, nodes, err) &&
           buffer_reserve(&t->levels, t->device, TREE_LEVELS * sizeof(cl_uint), err) &&
           buffer_reserve(&t->counters, t->device, QUERY_COUNTERS * sizeof(cl_uint), err);
}

static bool sort_keys(box_tree *t, timeline *times, uint32_t n, duet_error *err)
{
    const radix_lists lists = {&t->keys, &t->ids, &t->keys_spare, &t->ids_spare};
    return radix_sort_run(&t->radix, times, "sort", &lists, n, 32, err);
}

static bool sort_boxes(box_tree *t, timeline *times, const duet_pose *poses, uint32_t dims,
                       duet_error *err)
{
    size_t bytes = (size_t)t->n * sizeof *poses;
    fit_curve(t, poses, t->n, dims);
    return buffer_hold(&t->objects, t->device, (void *)poses, bytes, err) &&
           timeline_write(times, "send objects", &t->objects, poses, bytes, err) &&
           timeline_fill(times, "clear", &t->counters, 0, 0, QUERY_COUNTERS, err) &&
           timeline_launch(times, "keys", t->key, t->n, t, err) && sort_keys(t, times, t->n, err);
}

static bool check_objects(box_tree *t, timeline *times, duet_error *err)
{
    cl_uint counters[QUERY_COUNTERS];
    if (!timeline_read(times, "check", &t->counters, counters, sizeof counters, err))
        return false;
    if (counters[BAD_LATEST] == 0)
        return true;
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %u is not a number, infinite, negative, without rotation, or above "
                     "2^100",
                     ~counters[BAD_LATEST]);
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

bool box_tree_build(box_tree *t, timeline *times, const duet_pose *poses, uint32_t n, uint32_t dims,
                    duet_error *err)
{
    cl_uint first[TREE_LEVELS + 1] = {0};
    if (n > MOST_BOXES)
        return error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a query takes at most %d", n,
                         MOST_BOXES);
    t->n = n;
    if (n == 0)
        return true;
    uint32_t n_nodes = plan_levels(t, first);
    t->slots = nodes_for(n) * TREE_WIDTH;
    bool ok = reserve(t, n_nodes, err) && sort_boxes(t, times, poses, dims, err) &&
              timeline_write(times, "send objects", &t->levels, first, TREE_LEVELS * sizeof *first,
                             err) &&
              make_levels(t, times, first, n_nodes, err) && check_objects(t, times, err);
    if (t->objects.borrowed) // the caller may free it
        buffer_release(&t->objects);
    return ok;
}

bool box_tree_order_rays(box_tree *t, timeline *times, const buffer *rays, uint32_t n,
                         duet_error *err)
{
    uint32_t n_boxes = t->n;
    t->rays = *rays;
    t->n = n;
    bool ok = reserve_lists(t, n, err) && timeline_launch(times, "keys", t->ray_key, n, t, err) &&
              sort_keys(t, times, n, err);
    t->n = n_boxes;
    return ok;
}
