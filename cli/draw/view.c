// SPDX-License-Identifier: MIT
#include "cli/draw/view.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// Not along a diagonal: boxes on one would lie behind each other.
const look oblique = {
    .right = {-8 / 17.0, 15 / 17.0, 0},
    .up = {-120 / 289.0, -64 / 289.0, 15 / 17.0},
    .near = {225 / 289.0, 120 / 289.0, 8 / 17.0},
    .light = {0.30, 0.55, 0.78},
    .dark = 0.72,
    .bright = 0.28,
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

extent extent_empty(void)
{
    return (extent){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

void extent_add(extent *e, const double p[3])
{
    for (int k = 0; k < 3; ++k) {
        e->lower[k] = fmin(e->lower[k], p[k]);
        e->upper[k] = fmax(e->upper[k], p[k]);
    }
}

static point project(const look *from, uint32_t dims, const double p[3])
{
    return dims == 2 ? (point){p[0], -p[1]} : (point){dot(from->right, p), -dot(from->up, p)};
}

static corners corners_of_extent(const extent *e)
{
    corners all = {0};
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k)
            all.at[i][k] = i >> k & 1 ? e->upper[k] : e->lower[k];
    return all;
}

view view_fit(const look *from, uint32_t dims, const extent *shown, point least, point most)
{
    point low = {INFINITY, INFINITY};
    point high = {-INFINITY, -INFINITY};
    corners all = corners_of_extent(shown);
    for (int i = 0; i < 8; ++i) {
        point p = project(from, dims, all.at[i]);
        low = (point){fmin(low.x, p.x), fmin(low.y, p.y)};
        high = (point){fmax(high.x, p.x), fmax(high.y, p.y)};
    }
    double width = fmax(high.x - low.x, 1e-300);
    double height = fmax(high.y - low.y, 1e-300);
    view v = {.look = from, .dims = dims, .shown = *shown};
    v.scale = fmin((most.x - least.x) / width, (most.y - least.y) / height);
    v.at.x = 0.5 * (least.x + most.x) - 0.5 * (low.x + high.x) * v.scale;
    v.at.y = 0.5 * (least.y + most.y) - 0.5 * (low.y + high.y) * v.scale;
    return v;
}

point view_point(const view *v, const double p[3])
{
    point flat = project(v->look, v->dims, p);
    return (point){v->at.x + v->scale * flat.x, v->at.y + v->scale * flat.y};
}

double view_nearness(const view *v, const double p[3])
{
    return v->dims == 3 ? dot(v->look->near, p) : 0;
}

static void turn_of(const duet_pose *box, uint32_t dims, double turn[3][3])
{
    double x = dims == 3 ? box->rotation[0] : 0;
    double y = dims == 3 ? box->rotation[1] : 0;
    double z = box->rotation[2];
    double w = box->rotation[3];
    double s = 1 / (x * x + y * y + z * z + w * w);
    const double m[3][3] = {
        {s * (w * w + x * x - y * y - z * z), s * 2 * (x * y - w * z), s * 2 * (x * z + w * y)},
        {s * 2 * (x * y + w * z), s * (w * w - x * x + y * y - z * z), s * 2 * (y * z - w * x)},
        {s * 2 * (x * z - w * y), s * 2 * (y * z + w * x), s * (w * w - x * x - y * y + z * z)}};
    memcpy(turn, m, sizeof m);
}

corners corners_of(const duet_pose *box, uint32_t dims)
{
    corners all = {0};
    turn_of(box, dims, all.turn);
    for (int i = 0; i < 8; ++i)
        for (uint32_t row = 0; row < dims; ++row) {
            all.at[i][row] = box->centre[row];
            for (uint32_t k = 0; k < dims; ++k)
                all.at[i][row] += (i >> k & 1 ? 1 : -1) * all.turn[row][k] * box->half_extents[k];
        }
    return all;
}

// The four corners on one side of an axis, a radius out, in the order of a walk about it.
static void face(const view *v, const corners *all, int axis, int side, point walk[4])
{
    int u = 1 << (axis + 1) % 3;
    int w = 1 << (axis + 2) % 3;
    int from = side << axis;
    const int order[4] = {from, from | u, from | u | w, from | w};
    for (int i = 0; i < 4; ++i) {
        double at[3];
        for (int k = 0; k < 3; ++k)
            at[k] = all->at[order[i]][k] + (side ? 1 : -1) * all->radius * all->turn[k][axis];
        walk[i] = view_point(v, at);
    }
}

static colour shade(colour c, double light)
{
    return (colour){c.red * light, c.green * light, c.blue * light, c.alpha};
}

static void draw_faces(const view *v, canvas *c, const corners *all, const box_ink *ink)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double normal[3] = {all->turn[0][axis], all->turn[1][axis], all->turn[2][axis]};
        int side = dot(normal, v->look->near) > 0; // which of the two is seen
        double lit = (side ? 1 : -1) * dot(normal, v->look->light);
        colour fill = shade(ink->fill, v->look->dark + v->look->bright * fmax(lit, 0));
        point walk[4];
        face(v, all, axis, side, walk);
        canvas_polygon(c, walk, 4, fill, ink->edge);
    }
}

// The area of a rounded box: the outline of its corners, a radius further out.
static void draw_outline(const view *v, canvas *c, const corners *all, const box_ink *ink)
{
    enum { SIDES = 64 };
    double unit = v->scale * (v->dims == 3 ? sqrt(dot(v->look->right, v->look->right)) : 1);
    point walk[SIDES];
    for (int i = 0; i < SIDES; ++i) {
        double angle = 2 * 3.14159265358979323846 * i / SIDES, furthest = -INFINITY;
        point way = {cos(angle), sin(angle)}, at = {0, 0};
        for (int k = 0; k < (v->dims == 3 ? 8 : 4); ++k) {
            point p = view_point(v, all->at[k]);
            double far = p.x * way.x + p.y * way.y;
            at = far > furthest ? p : at;
            furthest = fmax(far, furthest);
        }
        walk[i] = (point){at.x + all->radius * unit * way.x, at.y + all->radius * unit * way.y};
    }
    canvas_polygon(c, walk, SIDES, ink->fill, ink->edge);
}

static void draw_rounded(const view *v, canvas *c, const corners *box, const box_ink *ink)
{
    if (v->dims == 2) {
        draw_outline(v, c, box, ink);
        return;
    }
    colour round = shade(ink->fill, v->look->dark + 0.5 * v->look->bright);
    colour edge = ink->edge.alpha > 0 ? ink->edge : shade(ink->fill, v->look->dark);
    draw_outline(v, c, box, &(box_ink){round, edge});
    draw_faces(v, c, box, ink);
}

void view_box(const view *v, canvas *c, const corners *box, const box_ink *ink)
{
    point walk[4];
    if (box->radius > 0) {
        draw_rounded(v, c, box, ink);
        return;
    }
    if (v->dims == 3) {
        draw_faces(v, c, box, ink);
        return;
    }
    face(v, box, 2, 0, walk);
    canvas_polygon(c, walk, 4, ink->fill, ink->edge);
}

// The greatest round length that is drawn at most so long, in units of the scene.
static double bar_length(double pixels_a_unit, double most_px)
{
    static const double times[] = {5, 2, 1};
    double power = pow(10, floor(log10(most_px / pixels_a_unit)));
    for (int i = 0; i < 3; ++i)
        if (times[i] * power * pixels_a_unit <= most_px)
            return times[i] * power;
    return power;
}

void view_scale_bar(const view *v, canvas *c, point at, double words_px, colour ink)
{
    const double most_px = 140, tick_px = 4;
    double pixels = v->scale * (v->dims == 3 ? sqrt(dot(v->look->right, v->look->right)) : 1);
    double length = bar_length(pixels, most_px);
    point end = {at.x + length * pixels, at.y};
    char words[64];
    canvas_line(c, at, end, ink, 2);
    canvas_line(c, (point){at.x, at.y - tick_px}, (point){at.x, at.y + tick_px}, ink, 2);
    canvas_line(c, (point){end.x, end.y - tick_px}, (point){end.x, end.y + tick_px}, ink, 2);
    snprintf(words, sizeof words, "%.6g unit%s of length", length, length == 1 ? "" : "s");
    canvas_words(c, (point){end.x + 8, at.y + 0.35 * words_px}, words_px, ink, words);
}

void view_frame(const view *v, canvas *c, const extent *e, colour ink)
{
    corners all = corners_of_extent(e);
    for (int i = 0; i < (v->dims == 3 ? 8 : 4); ++i)
        for (uint32_t k = 0; k < v->dims; ++k)
            if (!(i >> k & 1))
                canvas_line(c, view_point(v, all.at[i]), view_point(v, all.at[i | 1 << k]), ink, 1);
}
