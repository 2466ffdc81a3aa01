// SPDX-License-Identifier: MIT
// Cells behind, boxes from far to near, pairs in front, and where boxes are left out
// the whole scene small in a corner.
#include "cli/draw/sketch.h"
#include "cli/say.h"

#include <math.h>
#include <stdio.h>

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
        corners all = sketch_corners(&s->boxes[i], v->dims);
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
        n += snprintf(words + n, size - (size_t)n, " and %u coarser level%s", g->n_levels - 1,
                      g->n_levels > 2 ? "s" : "");
    if (info->cell > 0 && g->edge > info->cell * 1.01F)
        snprintf(words + n, size - (size_t)n,
                 "; the %.4g asked for is too small for the largest box", (double)info->cell);
}

static void write_words(const sketch *s, canvas *c, double left, double height)
{
    char words[512];
    const duet_scene_info *info = s->info;
    snprintf(words, sizeof words, "%s: %s in %uD, %s (%s)", info->name,
             say_things(info->n, "box", "boxes").chars, info->dims,
             say_things(s->n_pairs, "pair collides", "pairs collide").chars,
             say_things(s->n_colliding, "box", "boxes").chars);
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
             say_things(s->n, "box", "boxes").chars);
    canvas_words(c, at, words_px, canvas_ink, words);
}

void sketch_draw(const sketch *s, canvas *c, double width, double height)
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
