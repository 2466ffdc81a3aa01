// SPDX-License-Identifier: MIT
#include "cli/draw/sketch.h"

#include "base/error.h"
#include "cli/inputs.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/scene/scene.h"

#include <math.h>
#include <stdlib.h>

enum { CROWD_MOST = 4000 };

static const uint32_t NOT_DRAWN = UINT32_MAX;

static grid_objects objects_of(const duet_scene *scene)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    return (grid_objects){.kind = scene_kind(info),
                          .shape = info->shape,
                          .dims = info->dims,
                          .origin = info->origin_edge,
                          .all = {.rows = duet_scene_get_objects(scene, scene_kind(info)),
                                  .row_bytes = origin_row_bytes(info->shape, info->origin_edge),
                                  .n = info->n}};
}

static void centre_of(const sketch *s, const duet_scene *scene, uint32_t id, double centre[3])
{
    grid_objects objects = objects_of(scene);
    grid_centre_of(centre, &objects, id);
    for (int k = 0; k < 3; ++k)
        centre[k] -= s->from[k];
}

static duet_rounded_box box_of(const sketch *s, const duet_scene *scene, uint32_t id)
{
    grid_objects objects = objects_of(scene);
    duet_rounded_box box = {.pose.rotation = {0, 0, 0, 1}};
    double centre[3];
    if (s->info->shape == DUET_SHAPE_BOUNDS) {
        const duet_bounds *b = &((const duet_bounds *)objects.all.rows)[id];
        for (int k = 0; k < 3; ++k)
            box.pose.half_extents[k] = 0.5F * b->upper[k] - 0.5F * b->lower[k];
    } else if (s->info->shape == DUET_SHAPE_POSES) {
        box.pose = *origin_pose(objects.all.rows, objects.origin, id);
    } else {
        box = scene_rounded_box(scene, id);
    }
    centre_of(s, scene, id, centre);
    for (int k = 0; k < 3; ++k)
        box.pose.centre[k] = (float)centre[k];
    return box;
}

corners sketch_corners(const duet_rounded_box *box, uint32_t dims)
{
    corners all = corners_of(&box->pose, dims);
    all.radius = (double)box->radius;
    return all;
}

static void add_box(extent *e, const duet_rounded_box *box, uint32_t dims)
{
    corners all = sketch_corners(box, dims);
    for (int i = 0; i < 8; ++i)
        for (int side = -1; side <= 1; side += 2) {
            double out[3] = {0};
            for (uint32_t k = 0; k < dims; ++k)
                out[k] = all.at[i][k] + side * all.radius;
            extent_add(e, out);
        }
}

// ---------------------------------------------------------------- the whole scene

static void add_world(extent *e, const duet_scene_info *info, const double from[3])
{
    double lower[3] = {0};
    double upper[3] = {0};
    for (uint32_t k = 0; k < info->dims; ++k) {
        lower[k] = info->lower[k] - from[k];
        upper[k] = info->upper[k] - from[k];
    }
    extent_add(e, lower);
    extent_add(e, upper);
}

static bool lay_grid(sketch *s, const duet_scene *scene, duet_error *err)
{
    const duet_scene_info *info = s->info;
    grid_needs needs;
    const grid_wish wish = {.lower = info->has_world ? info->lower : NULL,
                            .upper = info->has_world ? info->upper : NULL,
                            .edge = (double)info->cell};
    grid_objects objects = objects_of(scene);
    grid_needs_of(&needs, &objects, NULL);
    return grid_fit(&s->grid, &needs, &wish, &objects, err);
}

static bool look_at_all(sketch *s, const duet_scene *scene, duet_error *err)
{
    s->whole = extent_empty();
    if (s->info->n > 0)
        origin_corner(s->from, objects_of(scene).all.rows, s->info->origin_edge, 0);
    for (uint32_t id = 0; id < s->info->n; ++id) {
        duet_rounded_box box = box_of(s, scene, id);
        add_box(&s->whole, &box, s->info->dims);
    }
    if (s->info->has_world)
        add_world(&s->whole, s->info, s->from);
    return lay_grid(s, scene, err);
}

// ---------------------------------------------------------------- the sample

typedef struct near {
    double distance;
    uint32_t id;
} near;

static int by_distance(const void *a, const void *b)
{
    const near *x = a;
    const near *y = b;
    if (x->distance != y->distance)
        return x->distance < y->distance ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

// Puts the s->n nearest to the focus first, those farthest from the eye leading.
static void choose(const sketch *s, const duet_scene *scene, uint32_t focus, near *all)
{
    const view v = {.look = &oblique, .dims = s->info->dims};
    double middle[3];
    centre_of(s, scene, focus, middle);
    for (uint32_t id = 0; id < s->info->n; ++id) {
        double centre[3];
        centre_of(s, scene, id, centre);
        all[id] = (near){.id = id};
        for (int k = 0; k < 3; ++k)
            all[id].distance = fmax(all[id].distance, fabs(centre[k] - middle[k]));
    }
    qsort(all, s->info->n, sizeof *all, by_distance);
    for (uint32_t i = 0; i < s->n; ++i) {
        double centre[3];
        centre_of(s, scene, all[i].id, centre);
        all[i].distance = view_nearness(&v, centre);
    }
    qsort(all, s->n, sizeof *all, by_distance);
}

static void take_boxes(sketch *s, const duet_scene *scene, const near *chosen, uint32_t *places)
{
    for (uint32_t id = 0; id < s->info->n; ++id)
        places[id] = NOT_DRAWN;
    s->part = extent_empty();
    for (uint32_t i = 0; i < s->n; ++i) {
        s->boxes[i] = box_of(s, scene, chosen[i].id);
        places[chosen[i].id] = i;
        add_box(&s->part, &s->boxes[i], s->info->dims);
    }
}

static void take_crowd(sketch *s, const duet_scene *scene)
{
    uint32_t n = s->info->n;
    if (s->n == n)
        return;
    s->n_crowd = n < CROWD_MOST ? n : CROWD_MOST;
    for (uint32_t i = 0; i < s->n_crowd; ++i)
        centre_of(s, scene, (uint32_t)((uint64_t)i * n / s->n_crowd), s->crowd[i]);
}

static void take_links(sketch *s, const duet_pair *pairs, const uint32_t *places, bool *collides)
{
    for (uint64_t i = 0; i < s->n_pairs; ++i) {
        duet_pair p = pairs[i];
        s->n_colliding += !collides[p.a];
        collides[p.a] = true;
        s->n_colliding += !collides[p.b];
        collides[p.b] = true;
        if (places[p.a] != NOT_DRAWN && places[p.b] != NOT_DRAWN)
            s->links[s->n_links++] = (duet_pair){places[p.a], places[p.b]};
    }
    for (uint32_t id = 0; id < s->info->n; ++id)
        if (places[id] != NOT_DRAWN)
            s->colliding[places[id]] = collides[id];
}

static bool take_sample(sketch *s, const duet_scene *scene, const duet_pair *pairs, duet_error *err)
{
    uint32_t n = s->info->n;
    near *all = calloc(n + 1U, sizeof *all);
    uint32_t *places = calloc(n + 1U, sizeof *places);
    bool *collides = calloc(n + 1U, sizeof *collides);
    s->boxes = calloc(s->n + 1U, sizeof *s->boxes);
    s->colliding = calloc(s->n + 1U, sizeof *s->colliding);
    s->crowd = calloc(CROWD_MOST, sizeof *s->crowd);
    s->links = calloc(s->n_pairs + 1, sizeof *s->links);
    bool ok = all && places && collides && s->boxes && s->colliding && s->crowd && s->links;
    if (ok && n > 0) {
        choose(s, scene, s->n_pairs > 0 ? pairs[s->n_pairs / 2].a : n / 2, all);
        take_boxes(s, scene, all, places);
        take_links(s, pairs, places, collides);
        take_crowd(s, scene);
    }
    free(all);
    free(places);
    free(collides);
    return ok || no_memory(err, "a picture of %u objects", n);
}

bool sketch_make(sketch *s, const duet_scene *scene, uint32_t most, duet_error *err)
{
    duet_pair *pairs = NULL;
    *s = (sketch){.info = duet_scene_get_info(scene)};
    s->n = s->info->n < most ? s->info->n : most;
    bool ok = look_at_all(s, scene, err);
    ok = ok && inputs_find_reference(scene, DUET_LEVEL_CERTIFIED, &pairs, &s->n_pairs, err);
    ok = ok && take_sample(s, scene, pairs, err);
    duet_free(pairs);
    return ok;
}

void sketch_free(sketch *s)
{
    free(s->boxes);
    free(s->colliding);
    free(s->crowd);
    free(s->links);
}
