// SPDX-License-Identifier: MIT
#include "runtime/queries/tree.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/opencl/shared_work.h"
#include "runtime/queries/far_rows.h"

#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e700b };

duet_tree_def duet_default_tree_def(void)
{
    return (duet_tree_def){.share = DUET_SHARE_DEFAULT, .dims = 3, .cookie = COOKIE};
}

// ---------------------------------------------------------------- owner

// Two cells are up to 2^31 edges apart, and a float holds less than 2^100 without care.
static bool check_origin(const duet_tree_def *def, duet_error *err)
{
    if (!origin_is_edge(def->origin_edge) || def->origin_edge > 0x1p69f)
        return bad_argument(err,
                            "origin_edge is %g; expected 0, or a power of two from 2^-100 to 2^69",
                            (double)def->origin_edge);
    return def->origin_edge == 0.0f || def->shape == DUET_SHAPE_POSES ||
           bad_argument(
               err, "origin cells are for poses; expected an origin_edge of 0 for another shape");
}

static bool check_def(const duet_tree_def *def, duet_error *err)
{
    if (!error_def(def && def->cookie == COOKIE, "tree", "duet_default_tree_def", err) ||
        !error_def_pair(def->pair, "tree", err) || !error_def_dims(def->dims, err))
        return false;
    if ((unsigned)def->shape >= DUET_SHAPES)
        return bad_argument(err, "shape is %d; expected a duet_shape", (int)def->shape);
    return check_origin(def, err) &&
           (def->share == DUET_SHARE_DEFAULT || shared_work_check(def->share, err));
}

static void close_side(tree_side *s)
{
    timeline_clear(&s->times);
    buffer_release(&s->filters);
    box_tree_close(&s->boxes);
    program_set_close(s->programs);
    gen_close(s->gen);
    *s = (tree_side){0};
}

static bool open_side(tree_side *s, const duet_tree_def *def, int which, duet_error *err)
{
    *s = (tree_side){.device = &def->pair->devices[which]};
    s->gen = gen_open(def->pair->kernel_dir, err);
    s->programs = s->gen ? program_set_open(s->device, s->gen, &def->pair->builder, err) : NULL;
    return s->programs &&
           box_tree_open(&s->boxes, s->device, s->programs, def->dims, def->shape, def->origin_edge,
                         err) &&
           program_set_build(s->programs, err);
}

typedef struct building {
    duet_tree *tree;
    tree_side *side;
    uint32_t n_hidden;
    bool sent; // the side has the objects
} building;

static size_t tree_row_bytes(const duet_tree *tree)
{
    return box_tree_width(tree->def.shape, tree->def.origin_edge);
}

static size_t objects_bytes(const duet_tree *tree)
{
    return tree->n * tree_row_bytes(tree);
}

static bool send_objects(const duet_tree *tree, tree_side *s)
{
    buffer *to = &s->boxes.objects;
    return box_tree_hold(&s->boxes, s->device, tree->objects, tree->n, &s->err) &&
           (tree->n == 0 || timeline_write(&s->times, "send objects", to, tree->objects,
                                           objects_bytes(tree), &s->err));
}

static void build(void *arg)
{
    building *b = arg;
    tree_side *s = b->side;
    timeline_begin(&s->times, s->device, true);
    s->ok = (b->sent || send_objects(b->tree, s)) &&
            box_tree_build(&s->boxes, &s->times, b->tree->n, b->n_hidden, &s->err) &&
            timeline_finish(&s->times, &s->err);
    timeline_clear(&s->times);
}

// A device that gets its first share, with the objects that there are.
static bool add_side(duet_tree *tree, int which, duet_error *err)
{
    tree_side *s = &tree->sides[which];
    building work = {.tree = tree, .side = s, .n_hidden = tree->n_hidden};
    if (s->device)
        return true;
    if (!tree_fetch_objects(tree, err))
        return false;
    box_tree_close(&s->boxes); // B's, which the objects came from
    if (open_side(s, &tree->def, which, err)) {
        build(&work);
        if (s->ok)
            return true;
        error_copy(err, &s->err);
    }
    close_side(s);
    return false;
}

static bool open_sides(duet_tree *tree, uint32_t share, duet_error *err)
{
    const bool used[2] = {share > 0 || tree->sides[0].device,
                          share < DUET_SHARE_ONE || tree->sides[1].device};
    if (used[0] && used[1] && !tree->driver && !(tree->driver = thread_pool_open(1, err)))
        return false;
    return (!used[0] || add_side(tree, 0, err)) && (!used[1] || add_side(tree, 1, err));
}

bool duet_tree_set_share(duet_tree *tree, uint32_t share, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(tree, __func__, "tree", err))
        return false;
    if (share == DUET_SHARE_DEFAULT)
        share = duet_default_plan(tree->def.pair).share;
    if (!shared_work_check(share, err) || !open_sides(tree, share, err))
        return false;
    tree->def.share = share;
    tree->n_tuned = 0;
    return true;
}

static tuned_share *find_tuned(duet_tree *tree, const char *query)
{
    uint32_t i = 0;
    while (i < tree->n_tuned && strcmp(tree->tuned[i].query, query) != 0)
        ++i;
    return &tree->tuned[i];
}

uint32_t tree_share_of(const duet_tree *tree, const char *query)
{
    const tuned_share *tuned = find_tuned((duet_tree *)tree, query);
    return tuned < tree->tuned + tree->n_tuned ? tuned->share : tree->def.share;
}

bool tree_tune(duet_tree *tree, const query_name *query, uint32_t share, duet_error *err)
{
    tuned_share tuned = {.share = share};
    query_name_write(query, tuned.query);
    tuned_share *to = find_tuned(tree, tuned.query);
    bool is_new = to == tree->tuned + tree->n_tuned;
    if (is_new && tree->n_tuned == TREE_TUNED)
        return error_set(err, DUET_STATUS_TOO_MANY, "a tree has shares for at most %d queries",
                         TREE_TUNED);
    if (!open_sides(tree, share, err))
        return false;
    *to = tuned;
    tree->n_tuned += is_new;
    return true;
}

duet_tree *duet_tree_create(const duet_tree_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!check_def(def, err))
        return NULL;
    duet_tree *tree = calloc(1, sizeof *tree);
    if (!tree)
        return null_no_memory(err, "a tree");
    tree->def = *def;
    tree->filters_set = 1;
    if (def->share == DUET_SHARE_DEFAULT)
        tree->def.share = duet_default_plan(def->pair).share;
    device_pair_hold(def->pair);
    tree_hold(tree);
    if (!open_sides(tree, tree->def.share, err)) {
        duet_tree_destroy(tree);
        return NULL;
    }
    return tree;
}

void tree_hold(duet_tree *tree)
{
    atomic_fetch_add(&tree->users, 1);
}

void duet_tree_destroy(duet_tree *tree)
{
    if (!tree || atomic_fetch_sub(&tree->users, 1) > 1)
        return;
    thread_pool_close(tree->driver);
    close_side(&tree->sides[0]);
    close_side(&tree->sides[1]);
    duet_device_pair_destroy(tree->def.pair);
    free(tree->objects);
    free(tree->filters);
    ground_shape_free(&tree->ground);
    free(tree);
}

// ---------------------------------------------------------------- both sides

bool tree_run(duet_tree *tree, void (*work)(void *), void *a, void *b, duet_error *err)
{
    for (int which = 0; which < 2; ++which) {
        tree->sides[which].ok = true;
        tree->sides[which].err = (duet_error){0};
    }
    thread_pool_run_both(tree->driver, work, a, b);
    const tree_side *failed = &tree->sides[tree->sides[0].ok];
    return failed->ok || error_copy(err, &failed->err);
}

// ---------------------------------------------------------------- objects

static bool build_all(duet_tree *tree, uint32_t n_hidden, bool b_has_them, duet_error *err)
{
    building work[2];
    void *args[2];
    for (int which = 0; which < 2; ++which) {
        work[which] = (building){tree, &tree->sides[which], n_hidden, b_has_them && which == 1};
        args[which] = tree->sides[which].device ? &work[which] : NULL;
    }
    return tree_run(tree, build, args[0], args[1], err);
}

bool tree_build(duet_tree *tree, uint32_t n_hidden, bool b_has_them, duet_error *err)
{
    tree->fetched = !b_has_them;
    tree->n_hidden = n_hidden;
    if ((!tree->sides[0].device || tree_fetch_objects(tree, err)) &&
        build_all(tree, n_hidden, b_has_them, err))
        return true;
    tree_clear(tree);
    return false;
}

void tree_clear(duet_tree *tree)
{
    tree->n = tree->n_hidden = 0;
    build_all(tree, 0, false, NULL);
}

bool tree_fetch_objects(duet_tree *tree, duet_error *err)
{
    timeline times = {0};
    if (tree->fetched || tree->n == 0)
        return true;
    timeline_begin(&times, &tree->def.pair->devices[1], true);
    tree->fetched = timeline_read(&times, "fetch objects", &tree->sides[1].boxes.objects,
                                  tree->objects, objects_bytes(tree), err) &&
                    timeline_finish(&times, err);
    timeline_clear(&times);
    return tree->fetched;
}

// Memory that devices wrap is released before it moves.
bool tree_reserve_objects(duet_tree *tree, uint32_t n, duet_error *err)
{
    if (n > TREE_MOST_BOXES)
        return error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a tree takes at most %d", n,
                         TREE_MOST_BOXES);
    box_tree_forget_objects(&tree->sides[0].boxes);
    box_tree_forget_objects(&tree->sides[1].boxes);
    free(tree->filters);
    tree->filters = NULL;
    ++tree->filters_set;
    tree->n = n;
    void *objects = realloc(tree->objects, objects_bytes(tree) + 1);
    if (!objects) {
        tree_clear(tree);
        return no_memory(err, "%u objects", n);
    }
    tree->objects = objects;
    return true;
}

duet_filter *tree_reserve_filters(duet_tree *tree, duet_error *err)
{
    size_t bytes = ((size_t)tree->n + 1) * sizeof *tree->filters;
    if (!tree->filters && !(tree->filters = malloc(bytes)))
        return null_no_memory(err, "%u filters", tree->n);
    ++tree->filters_set;
    return tree->filters;
}

bool duet_tree_set_filters(duet_tree *tree, const duet_filter *filters, uint32_t n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(tree, __func__, "tree", err) ||
        (n > 0 && !error_given(filters, __func__, "filters", err)))
        return false;
    if (n != tree->n)
        return bad_argument(err, "%u filters; expected one for each of the tree's %u objects", n,
                            tree->n);
    duet_filter *to = tree_reserve_filters(tree, err);
    if (to && n > 0)
        memcpy(to, filters, n * sizeof *to);
    return to;
}

const duet_tree_def *tree_def(const duet_tree *tree)
{
    return &tree->def;
}

uint32_t tree_count(const duet_tree *tree)
{
    return tree->n;
}

typedef struct shape_row {
    duet_object_kind kind;
    const char *name;
} shape_row;

static const shape_row shape_rows[DUET_SHAPES] = {
    [DUET_SHAPE_POSES] = {DUET_OBJECT_POSES, "poses"},
    [DUET_SHAPE_BOUNDS] = {DUET_OBJECT_BOUNDS, "bounds"},
    [DUET_SHAPE_ROUNDED_BOXES] = {DUET_OBJECT_ROUNDED_BOXES, "rounded boxes"},
    [DUET_SHAPE_SPHERES] = {DUET_OBJECT_SPHERES, "spheres"},
};

static duet_object_kind tree_kind(const duet_tree *tree)
{
    return tree->def.origin_edge > 0.0f ? DUET_OBJECT_LARGE_POSES
                                        : shape_rows[tree->def.shape].kind;
}

const char *tree_shape_name(const duet_tree *tree)
{
    return tree->def.origin_edge > 0.0f ? "large poses" : shape_rows[tree->def.shape].name;
}

bool tree_takes(const duet_tree *tree, duet_object_kind kind, duet_error *err)
{
    return kind == tree_kind(tree) || bad_argument(err, "objects of kind %d; the tree is of %s",
                                                   (int)kind, tree_shape_name(tree));
}

void tree_find_middle(duet_tree *tree)
{
    const far_rows far = {tree->objects, tree->n, FAR_POSE_WORDS, FAR_POSE_CELL};
    if (!(tree->def.origin_edge > 0.0f))
        return;
    far_rows_middle(&far, tree->middle);
    far_rows_count_from(&far, tree->middle);
}

void tree_copy_rows(const duet_tree *tree, const void *objects, uint64_t n, void *rows)
{
    if (tree->def.shape != DUET_SHAPE_SPHERES) {
        if (n > 0)
            memcpy(rows, objects, (size_t)n * tree_row_bytes(tree));
        if (tree->def.origin_edge > 0.0f)
            far_rows_settle(&(far_rows){rows, n, FAR_POSE_WORDS, FAR_POSE_CELL},
                            tree->def.origin_edge);
        return;
    }
    for (uint64_t i = 0; i < n; ++i)
        ((duet_rounded_box *)rows)[i] = rounded_of_sphere((const duet_sphere *)objects + i);
}

bool duet_tree_set_objects(duet_tree *tree, duet_object_kind kind, const void *objects, uint32_t n,
                           duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(tree, __func__, "tree", err))
        return false;
    if (!tree_takes(tree, kind, err))
        return false;
    if (n > 0 && !objects)
        return bad_argument(err, "%u objects, but no memory with them", n);
    if (!tree_reserve_objects(tree, n, err))
        return false;
    tree_copy_rows(tree, objects, n, tree->objects);
    tree_find_middle(tree);
    return tree_build(tree, 0, false, err);
}
