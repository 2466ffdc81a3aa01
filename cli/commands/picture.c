// SPDX-License-Identifier: MIT
// duet picture: draws a scene, so that one sees at once whether it is what was
// meant. No device is needed: the pairs are the plain C reference's.
#include "base/error.h"
#include "cli/commands.h"
#include "cli/draw/view.h"
#include "cli/inputs.h"
#include "cli/report/table.h"
#include "runtime/broadphase/grid.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BOXES_2D = 500, BOXES_3D = 400 }; // more hide each other

typedef struct arguments {
    scene_options scene;
    const char *out;
    uint64_t most;
    uint64_t width;
} arguments;

static const option options[] = {
    OPTION_OUTPUT("output", out, "FILE", "the picture, a .svg or .png"),
    SCENE_OPTION_ROWS(scene),
    OPTION_COUNT("boxes", most, "K", "boxes that are drawn at most (500 in 2D, 400 in 3D)", 1,
                 100000),
    OPTION_COUNT("width", width, "PIXELS", "of the picture (1000)", 200, 8000),
    {0},
};

static const char *refuse(const void *given, char **operands)
{
    (void)operands;
    return ((const arguments *)given)->out
               ? NULL
               : "-o is missing: say where the picture goes, as -o scene.svg";
}

static const command_line line = {
    .name = "picture",
    .operands = "SCENE|FILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Draws a scene with its cells and its pairs, and a bar for scale; of a large one\n"
             "the boxes about a collision, and the whole of it in a corner.",
    .options = options,
    .refuse = refuse,
};

// ---------------------------------------------------------------- what is drawn

// A scene as it is to be drawn: its boxes or a sample of them, which of them collide,
// and the grid that Duet lays over them.
typedef struct sketch {
    const duet_scene_info *info; // of the scene
    grid grid;
    double from[3]; // what is drawn counts from there: with origin cells the first box's corner
    extent whole;   // all boxes, and the world where one is given
    uint64_t n_pairs;
    uint32_t n_colliding; // boxes that are in some pair

    // The drawn boxes:
    uint32_t n;
    duet_rounded_box *boxes; // from far to near
    bool *colliding;
    extent part;      // of the drawn boxes
    duet_pair *links; // pairs among them, by place in boxes
    uint64_t n_links;
    double (*crowd)[3]; // centres of a few thousand boxes of the whole scene
    uint32_t n_crowd;   // 0: all boxes are drawn
} sketch;

enum { CROWD_MOST = 4000 };

static const uint32_t NOT_DRAWN = UINT32_MAX;

static grid_objects objects_of(const duet_scene *scene)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    return (grid_objects){.array = duet_scene_get_objects(scene, scene_kind(info)),
                          .row_bytes = origin_row_bytes(info->shape, info->origin_edge),
                          .shape = info->shape,
                          .origin = info->origin_edge,
                          .n = info->n,
                          .dims = info->dims};
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
        const duet_bounds *b = &((const duet_bounds *)objects.array)[id];
        for (int k = 0; k < 3; ++k)
            box.pose.half_extents[k] = 0.5F * b->upper[k] - 0.5F * b->lower[k];
    } else if (s->info->shape == DUET_SHAPE_POSES) {
        box.pose = *origin_pose(objects.array, objects.origin, id);
    } else {
        box = scene_rounded_box(scene, id);
    }
    centre_of(s, scene, id, centre);
    for (int k = 0; k < 3; ++k)
        box.pose.centre[k] = (float)centre[k];
    return box;
}

static corners corners_of_box(const duet_rounded_box *box, uint32_t dims)
{
    corners all = corners_of(&box->pose, dims);
    all.radius = (double)box->radius;
    return all;
}

static void add_box(extent *e, const duet_rounded_box *box, uint32_t dims)
{
    corners all = corners_of_box(box, dims);
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
    grid_wish wish = {.has_world = info->has_world, .edge = (double)info->cell};
    for (int k = 0; k < 3; ++k) {
        wish.lower[k] = info->lower[k];
        wish.upper[k] = info->upper[k];
    }
    grid_objects objects = objects_of(scene);
    grid_needs_of(&needs, &objects, NULL);
    return grid_fit(&s->grid, &needs, &wish, &objects, err);
}

static bool look_at_all(sketch *s, const duet_scene *scene, duet_error *err)
{
    s->whole = extent_empty();
    if (s->info->n > 0)
        origin_corner(s->from, objects_of(scene).array, s->info->origin_edge, 0);
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
    return ok || error_set(err, DUET_STATUS_NO_MEMORY, "a picture of %u objects: no memory", n);
}

// Takes all boxes, or the `most` that lie nearest to a collision in the middle
// of the input. The pairs are the plain C reference's.
static bool sketch_make(sketch *s, const duet_scene *scene, uint32_t most, duet_error *err)
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

static void sketch_free(sketch *s)
{
    free(s->boxes);
    free(s->colliding);
    free(s->crowd);
    free(s->links);
}

// ---------------------------------------------------------------- how it looks

// Cells behind, boxes from far to near, pairs in front, and where boxes are left out
// the whole scene small in a corner.

static const colour white = {1, 1, 1, 0.93};
static const colour cell_ink = {0.30, 0.38, 0.50, 0.22};
static const colour pair_ink = {0.72, 0.06, 0.12, 0.9};
static const box_ink alone = {{0.66, 0.76, 0.88, 0.62}, {0.27, 0.38, 0.53, 0.9}};
static const box_ink collides = {{0.97, 0.62, 0.26, 0.78}, {0.58, 0.27, 0.04, 1}};
static const double closest_px = 5; // cells' lines that are nearer say nothing
static const double words_px = 15;

// Lines across axis `along`, in the plane where axis `still` is least.
static void draw_lines(const view *v, canvas *c, const sketch *s, const grid_level *level,
                       int along, int across, double width)
{
    double edge = 1 / (double)level->per_cell.s[along];
    double corner = grid_corner(level, s->info->origin_edge, (uint32_t)along) - s->from[along];
    double from = ceil((v->shown.lower[along] - corner) / edge);
    for (double at = corner + from * edge; at <= v->shown.upper[along]; at += edge) {
        double start[3] = {v->shown.lower[0], v->shown.lower[1], v->shown.lower[2]};
        start[along] = at;
        double end[3] = {start[0], start[1], start[2]};
        end[across] = v->shown.upper[across];
        canvas_line(c, view_point(v, start), view_point(v, end), cell_ink, width);
    }
}

// On the ground, in 3D on the two walls behind as well.
static void draw_cells(const view *v, canvas *c, const sketch *s)
{
    const grid *g = &s->grid;
    for (uint32_t l = 0; l < g->n_levels; ++l) {
        const grid_level *level = &g->levels[l];
        if (v->scale / (double)level->per_cell.s[0] < closest_px)
            continue;
        for (uint32_t along = 0; along < v->dims; ++along)
            for (uint32_t across = 0; across < v->dims; ++across)
                if (along != across)
                    draw_lines(v, c, s, level, (int)along, (int)across, 1 + 0.8 * l);
    }
}

static void draw_boxes(const sketch *s, const view *v, canvas *c)
{
    for (uint32_t i = 0; i < s->n; ++i) {
        corners all = corners_of_box(&s->boxes[i], v->dims);
        view_box(v, c, &all, s->colliding[i] ? &collides : &alone);
    }
}

static point centre_on(const sketch *s, const view *v, uint32_t place)
{
    const float *from = s->boxes[place].pose.centre;
    const double centre[3] = {from[0], from[1], s->info->dims == 3 ? from[2] : 0};
    return view_point(v, centre);
}

static void draw_links(const sketch *s, const view *v, canvas *c)
{
    for (uint64_t i = 0; i < s->n_links; ++i) {
        point a = centre_on(s, v, s->links[i].a);
        point b = centre_on(s, v, s->links[i].b);
        canvas_line(c, a, b, pair_ink, 1.6);
        canvas_dot(c, a, 1.9, pair_ink);
        canvas_dot(c, b, 1.9, pair_ink);
    }
}

// The whole scene, small, with a frame around the part that is drawn large.
static void draw_corner(const sketch *s, canvas *c, point least, point most)
{
    const point paper[4] = {least, {most.x, least.y}, most, {least.x, most.y}};
    canvas_polygon(c, paper, 4, white, canvas_grey);
    point inner = {least.x + 10, least.y + 10};
    view v = view_fit(&oblique, s->info->dims, &s->whole, inner, (point){most.x - 10, most.y - 26});
    view_frame(&v, c, &s->whole, cell_ink);
    for (uint32_t i = 0; i < s->n_crowd; ++i)
        canvas_dot(c, view_point(&v, s->crowd[i]), 0.8, alone.edge);
    view_frame(&v, c, &s->part, pair_ink);
    canvas_words(c, (point){least.x + 8, most.y - 8}, 11, canvas_grey,
                 "all boxes; framed: this part");
}

static void write_cells(const sketch *s, char *words, size_t size)
{
    const duet_scene_info *info = s->info;
    const grid *g = &s->grid;
    *words = '\0';
    if (info->n == 0)
        return;
    int n = snprintf(words, size, "cells of edge %.4g%s", (double)g->edge,
                     g->kind == GRID_HASHED ? ", in a hash table" : "");
    if (g->n_levels > 1)
        n += snprintf(words + n, size - (size_t)n, " and %u coarser levels", g->n_levels - 1);
    if (info->cell > 0 && g->edge > info->cell * 1.01F)
        snprintf(words + n, size - (size_t)n,
                 "; the %.4g asked for is too small for the largest box", (double)info->cell);
}

static void write_words(const sketch *s, canvas *c, double left, double height)
{
    char words[512];
    const duet_scene_info *info = s->info;
    snprintf(words, sizeof words, "%s: %s in %uD, %s (%s)", info->name,
             table_things(info->n, "box", "boxes").chars, info->dims,
             table_things(s->n_pairs, "pair collides", "pairs collide").chars,
             table_things(s->n_colliding, "box", "boxes").chars);
    canvas_words(c, (point){left, height - 62}, words_px, canvas_ink, words);
    write_cells(s, words, sizeof words);
    canvas_words(c, (point){left, height - 40}, words_px, canvas_grey, words);
    point at = {left, height - 18};
    at.x = canvas_words(c, at, words_px, collides.edge, "\u25a0 collides   ");
    at.x = canvas_words(c, at, words_px, alone.edge, "\u25a0 alone   ");
    at.x = canvas_words(c, at, words_px, pair_ink, "\u2014 a pair   ");
    if (s->n == info->n)
        return;
    snprintf(words, sizeof words, "a sample: the %s nearest to a collision",
             table_things(s->n, "box", "boxes").chars);
    canvas_words(c, at, words_px, canvas_ink, words);
}

// Draws it, with lines of words below.
static void sketch_draw(const sketch *s, canvas *c, double width, double height)
{
    const double margin = 24;
    const double corner = 190;
    bool all = s->n == s->info->n;
    double below = all ? 116 : corner + 16;
    const extent *shown = all ? &s->whole : &s->part;
    if (s->n > 0) {
        view v = view_fit(&oblique, s->info->dims, shown, (point){margin, margin},
                          (point){width - margin, height - below});
        draw_cells(&v, c, s);
        view_frame(&v, c, shown, canvas_grey);
        draw_boxes(s, &v, c);
        draw_links(s, &v, c);
        view_scale_bar(&v, c, (point){margin, height - 92}, words_px, canvas_grey);
        if (!all)
            draw_corner(s, c, (point){width - corner - 8, height - corner - 8},
                        (point){width - 8, height - 8});
    }
    write_words(s, c, margin, height);
}

// ---------------------------------------------------------------- the command

static uint32_t most_boxes(const arguments *args, const duet_scene *scene)
{
    if (args->most > 0)
        return (uint32_t)args->most;
    return duet_scene_get_info(scene)->dims == 2 ? BOXES_2D : BOXES_3D;
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    sketch s = {0};
    double width = (double)args->width;
    canvas *c = canvas_open(args->out, width, width, err);
    duet_scene *scene = c ? inputs_load_scene(operands[0], &args->scene, err) : NULL;
    bool ok = scene && sketch_make(&s, scene, most_boxes(args, scene), err);
    if (ok)
        sketch_draw(&s, c, width, width);
    ok = canvas_close(c, ok, err);
    sketch_free(&s);
    duet_scene_destroy(scene);
    return ok;
}

int command_picture(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .width = 1000};
    return options_run(&line, argc, argv, &args, run);
}
