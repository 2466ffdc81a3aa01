// SPDX-License-Identifier: MIT
#include "cli/draw/snapshot.h"

#include "base/compare.h"
#include "base/error.h"
#include "base/output.h"
#include "cli/body_states.h"
#include "cli/draw/relief.h"
#include "cli/draw/view.h"
#include "cli/say.h"
#include "runtime/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { WIDTH = 960, HEIGHT = 720 };
enum { EDGE = 200 }; // one in so many objects may lie outside, on either side

static const colour paper = {0.97, 0.97, 0.97, 1};
static const colour floor_fill = {0.88, 0.88, 0.86, 1};
static const colour massless = {0.72, 0.73, 0.74, 1};
static const colour shot = {0.88, 0.10, 0.14, 1};

// ---------------------------------------------------------------- what is seen

// A body that commands brought was shot too.
static bool was_shot(const snapshot *s, const body_states *c, uint32_t place)
{
    return c->ids[place] >= s->n || s->is_shot[place];
}

static duet_rounded_box body_of(const duet_scene *scene, uint32_t id)
{
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    return poses ? (duet_rounded_box){poses[id], 0} : scene_rounded_box(scene, id);
}

// All objects along an axis but a few on either side, and but what was shot.
static bool find_extent(const snapshot *s, const body_states *c, uint32_t axis, double *lower,
                        double *upper, duet_error *err)
{
    double *lowers = malloc(2 * ((size_t)c->n + 1) * sizeof *lowers);
    if (!lowers)
        return no_memory(err, "a picture of %u objects", c->n);
    double *uppers = lowers + c->n;
    uint32_t n = 0;
    for (uint32_t i = 0; i < c->n; ++i) {
        const float *h = c->boxes[i].pose.half_extents;
        double core = fmax(h[0], fmax(h[1], s->def->dims == 3 ? h[2] : 0.0));
        double reach = core + c->boxes[i].radius;
        if (!body_states_has(c, i) || was_shot(s, c, i))
            continue;
        lowers[n] = c->states[i].centre[axis] - reach;
        uppers[n++] = c->states[i].centre[axis] + reach;
    }
    qsort(lowers, n, sizeof *lowers, compare_double);
    qsort(uppers, n, sizeof *uppers, compare_double);
    *lower = n > 0 ? lowers[n / EDGE] : 0.0;
    *upper = n > 0 ? uppers[n - 1 - n / EDGE] : 0.0;
    free(lowers);
    return true;
}

// Walls stay in view, but not the empty space below a high ceiling.
static bool find_part(const snapshot *s, const body_states *c, extent *part, duet_error *err)
{
    const duet_motion_def *d = s->def;
    double *lower = part->lower;
    double *upper = part->upper;
    *part = (extent){0};
    for (uint32_t k = 0; k < d->dims; ++k) {
        if (!find_extent(s, c, k, &lower[k], &upper[k], err))
            return false;
        if (d->boundary == DUET_BOUNDARY_NONE)
            continue;
        lower[k] = fmin(lower[k], d->lower[k]);
        if (k < 2)
            upper[k] = fmax(upper[k], d->upper[k]);
    }
    relief_widen(&c->def, part);
    return true;
}

// ---------------------------------------------------------------- colours

// From blue over green to amber.
static colour colour_at(double part)
{
    static const colour scale[] = {
        {0.19, 0.30, 0.55, 1}, {0.17, 0.53, 0.64, 1}, {0.42, 0.68, 0.48, 1}, {0.93, 0.74, 0.33, 1}};
    const int last = (int)(sizeof scale / sizeof *scale) - 1;
    double at = last * fmin(1.0, fmax(0.0, part));
    int i = at >= last ? last - 1 : (int)at;
    double t = at - i;
    const colour *a = &scale[i], *b = &scale[i + 1];
    return (colour){a->red + t * (b->red - a->red), a->green + t * (b->green - a->green),
                    a->blue + t * (b->blue - a->blue), 1};
}

static colour lit(colour t, double light)
{
    return (colour){light * t.red, light * t.green, light * t.blue, 1};
}

// The height at which an object began, or its distance from what attracts.
static double place_of(const duet_motion_def *d, const duet_state *s)
{
    if (d->attraction == 0.0)
        return s->centre[d->dims - 1];
    double z = d->dims == 3 ? s->centre[2] - d->centre[2] : 0.0;
    return hypot(hypot(s->centre[0] - d->centre[0], s->centre[1] - d->centre[1]), z);
}

// Neighbours differ a little, so that one is told from the other.
static double brightness_of(uint32_t id)
{
    return 0.86 + 0.28 * fmod(id * 0.618033988749895, 1.0);
}

static void colour_objects(snapshot *s, const duet_state *start)
{
    const duet_body *bodies = duet_scene_get_bodies(s->scene);
    double least = INFINITY, most = -INFINITY;
    for (uint32_t i = 0; i < s->n; ++i) {
        double place = place_of(s->def, &start[i]);
        least = fmin(least, place);
        most = fmax(most, place);
    }
    for (uint32_t i = 0; i < s->n; ++i) {
        double part = (place_of(s->def, &start[i]) - least) / fmax(most - least, 1e-300);
        bool fixed = bodies && !(bodies[i].mass > 0.0f);
        s->colours[i] = fixed           ? massless
                        : s->is_shot[i] ? shot
                                        : lit(colour_at(part), brightness_of(i));
    }
}

// A speed that calls for the effect `continuous`: more than half the least half extent a step.
static bool moves_fast(const duet_motion_def *d, const duet_rounded_box *body, const duet_state *s)
{
    const duet_pose *p = &body->pose;
    double speed = hypot(s->velocity[0], s->velocity[1]);
    double least = fmin(p->half_extents[0], p->half_extents[1]);
    if (d->dims == 3) {
        speed = hypot(speed, s->velocity[2]);
        least = fmin(least, p->half_extents[2]);
    }
    return speed * d->dt > 0.5 * (least + body->radius);
}

// None was shot if all are that fast, as on orbits.
static void find_shot(snapshot *s, const duet_state *start)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n; ++i) {
        const duet_rounded_box body = body_of(s->scene, i);
        s->is_shot[i] = moves_fast(s->def, &body, &start[i]);
        n += s->is_shot[i];
    }
    if (n > s->n / 2)
        memset(s->is_shot, 0, s->n * sizeof *s->is_shot);
}

bool snapshot_begin(snapshot *s, const duet_motion_def *def, const duet_scene *scene,
                    duet_motion *motion, duet_error *err)
{
    *s = (snapshot){.def = def, .scene = scene, .n = duet_scene_get_info(scene)->n};
    s->colours = calloc((size_t)s->n + 1, sizeof *s->colours);
    s->is_shot = calloc((size_t)s->n + 1, sizeof *s->is_shot);
    if (!s->colours || !s->is_shot)
        return no_memory(err, "a picture of %u objects", s->n);
    body_states start = {0};
    bool ok = body_states_read(&start, motion, err);
    if (ok) {
        find_shot(s, start.states);
        colour_objects(s, start.states);
    }
    ok = ok && find_part(s, &start, &s->part, err);
    body_states_free(&start);
    return ok;
}

void snapshot_end(snapshot *s)
{
    free(s->colours);
    free(s->is_shot);
}

// ---------------------------------------------------------------- drawing

// From above and aside.
static const look aside = {
    .right = {0.8, 0.6, 0},
    .up = {-0.2681, 0.3575, 0.8946},
    .near = {0.5369, -0.7158, 0.4474},
    .light = {0.35, -0.45, 0.82},
    .dark = 0.45,
    .bright = 0.6,
};

// A box, and how near the part of it is that is farthest from the eye: what is drawn
// by that order hides what it should, also where a large box is the floor of small ones.
typedef struct block {
    corners corners;
    double nearness;
    colour fill;
} block;

static int from_far_to_near(const void *x, const void *y)
{
    double a = ((const block *)x)->nearness, b = ((const block *)y)->nearness;
    return (a > b) - (a < b);
}

static void move_to(corners *box, const double centre[3], uint32_t dims)
{
    for (int i = 0; i < 8; ++i)
        for (uint32_t k = 0; k < dims; ++k)
            box->at[i][k] += centre[k];
}

static block block_of(const snapshot *s, const view *v, const body_states *c, uint32_t place)
{
    const duet_state *state = &c->states[place];
    duet_pose box = c->boxes[place].pose;
    for (int k = 0; k < 4; ++k)
        box.rotation[k] = (float)state->rotation[k];
    memset(box.centre, 0, sizeof box.centre);
    block b = {corners_of(&box, v->dims), INFINITY,
               c->ids[place] < s->n ? s->colours[place] : shot};
    b.corners.radius = c->boxes[place].radius;
    move_to(&b.corners, state->centre, v->dims);
    for (int i = 0; i < 8; ++i)
        b.nearness = fmin(b.nearness, view_nearness(v, b.corners.at[i]));
    return b;
}

// Cairo takes no coordinates that are far outside.
static bool is_near_picture(const view *v, const block *b)
{
    bool near = true;
    for (int i = 0; i < 8; ++i) {
        point p = view_point(v, b->corners.at[i]);
        near = near && fabs(p.x) < 1e5 && fabs(p.y) < 1e5;
    }
    return near;
}

// Before a box all of the ground that is farther than the box's nearest part.
static void draw_blocks(const snapshot *s, relief *hills, canvas *c, block *blocks,
                        const body_states *bodies)
{
    const view *v = hills->view;
    uint32_t n = 0;
    for (uint32_t i = 0; i < bodies->n; ++i)
        if (body_states_has(bodies, i))
            blocks[n++] = block_of(s, v, bodies, i);
    if (v->dims == 3)
        qsort(blocks, n, sizeof *blocks, from_far_to_near);
    for (uint32_t i = 0; i < n; ++i) {
        relief_draw(hills, c, relief_nearness(hills, &blocks[i].corners));
        if (is_near_picture(v, &blocks[i]))
            view_box(v, c, &blocks[i].corners, &(box_ink){.fill = blocks[i].fill});
    }
    relief_draw(hills, c, INFINITY);
}

// The floor of a world with walls; in 2D what they enclose.
static void draw_floor(const view *v, canvas *c, const duet_motion_def *d)
{
    double z = d->dims == 3 ? d->lower[2] : 0.0;
    const double at[4][3] = {{d->lower[0], d->lower[1], z},
                             {d->upper[0], d->lower[1], z},
                             {d->upper[0], d->upper[1], z},
                             {d->lower[0], d->upper[1], z}};
    point walk[4];
    for (int i = 0; i < 4; ++i)
        walk[i] = view_point(v, at[i]);
    if (d->boundary != DUET_BOUNDARY_NONE)
        canvas_polygon(c, walk, 4, floor_fill, floor_fill);
}

static bool has_shot(const snapshot *s, const body_states *c)
{
    for (uint32_t i = 0; i < c->n; ++i)
        if (body_states_has(c, i) && was_shot(s, c, i))
            return true;
    return false;
}

static void write_caption(const snapshot *s, const view *v, canvas *c, const body_states *bodies,
                          double time)
{
    const double left = 24, words_px = 15;
    char words[256];
    snprintf(words, sizeof words, "%.80s: %s in %uD after %.3f s",
             duet_scene_get_info(s->scene)->name,
             say_things(body_states_count(bodies), "box", "boxes").chars, v->dims, time);
    canvas_words(c, (point){left, HEIGHT - 44}, words_px, canvas_ink, words);
    snprintf(words, sizeof words, "colour: how %s a box began%s",
             s->def->attraction == 0.0 ? "high" : "far from the centre",
             has_shot(s, bodies) ? "; red: shot" : "");
    canvas_words(c, (point){left, HEIGHT - 20}, words_px, canvas_grey, words);
    if (bodies->n > 0)
        view_scale_bar(v, c, (point){WIDTH - 330, HEIGHT - 25}, words_px, canvas_grey);
}

static bool draw(const snapshot *s, const char *path, const body_states *bodies, const extent *part,
                 double time, duet_error *err)
{
    static const point page[4] = {{0, 0}, {WIDTH, 0}, {WIDTH, HEIGHT}, {0, HEIGHT}};
    canvas *c = canvas_open(path, WIDTH, HEIGHT, err);
    if (!c)
        return false;
    block *blocks = calloc((size_t)bodies->n + 1, sizeof *blocks);
    view v = view_fit(&aside, s->def->dims, part, (point){0.05 * WIDTH, 0.05 * HEIGHT},
                      (point){0.95 * WIDTH, HEIGHT - 76});
    canvas_polygon(c, page, 4, paper, paper);
    draw_floor(&v, c, s->def);
    relief hills;
    bool ok = relief_begin(&hills, &bodies->def, &v, err) &&
              (blocks || no_memory(err, "the picture %s", path));
    if (ok)
        draw_blocks(s, &hills, c, blocks, bodies);
    write_caption(s, &v, c, bodies, time);
    ok = canvas_close(c, ok, err);
    relief_end(&hills);
    free(blocks);
    return ok;
}

bool snapshot_try(const char *path, duet_error *err)
{
    struct stat info;
    const bool is_device = stat(path, &info) == 0 && !S_ISREG(info.st_mode);
    return output_check(path, err) &&
           (!is_device || canvas_close(canvas_open(path, WIDTH, HEIGHT, err), true, err));
}

bool snapshot_frame(const snapshot *s, const char *path, duet_motion *motion, double time,
                    duet_error *err)
{
    body_states bodies = {0};
    bool ok = body_states_read(&bodies, motion, err) && draw(s, path, &bodies, &s->part, time, err);
    body_states_free(&bodies);
    return ok;
}

bool snapshot_picture(const snapshot *s, const char *path, duet_motion *motion, double time,
                      duet_error *err)
{
    extent part;
    body_states bodies = {0};
    bool ok = body_states_read(&bodies, motion, err) && find_part(s, &bodies, &part, err) &&
              draw(s, path, &bodies, &part, time, err);
    body_states_free(&bodies);
    return ok;
}
