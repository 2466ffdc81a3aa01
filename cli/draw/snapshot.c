// SPDX-License-Identifier: MIT
#include "cli/draw/snapshot.h"

#include "base/error.h"
#include "cli/draw/raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 960, HEIGHT = 720 };
enum { EDGE = 200 }; // one in so many objects may lie outside, on either side

static const tint paper = {0.97, 0.97, 0.97};
static const tint ground = {0.88, 0.88, 0.86};
static const tint massless = {0.72, 0.73, 0.74};
static const tint shot = {0.88, 0.10, 0.14};

// ---------------------------------------------------------------- what is seen

static int by_number(const void *x, const void *y)
{
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

// All objects along an axis but a few on either side, and but what was shot.
static bool find_extent(const snapshot *s, const duet_state *states, uint32_t axis, double *lower,
                        double *upper, duet_error *err)
{
    const duet_pose *poses = duet_scene_get_objects(s->scene, DUET_OBJECT_POSES);
    double *lowers = malloc(2 * ((size_t)s->n + 1) * sizeof *lowers);
    if (!lowers)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a picture of %u objects", s->n);
    double *uppers = lowers + s->n;
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n; ++i) {
        const float *h = poses[i].half_extents;
        double reach = fmax(h[0], fmax(h[1], s->def->dims == 3 ? h[2] : 0.0));
        if (s->is_shot[i])
            continue;
        lowers[n] = states[i].centre[axis] - reach;
        uppers[n++] = states[i].centre[axis] + reach;
    }
    qsort(lowers, n, sizeof *lowers, by_number);
    qsort(uppers, n, sizeof *uppers, by_number);
    *lower = n > 0 ? lowers[n / EDGE] : 0.0;
    *upper = n > 0 ? uppers[n - 1 - n / EDGE] : 0.0;
    free(lowers);
    return true;
}

// Walls stay in view, but not the empty space below a high ceiling.
static bool find_part(const snapshot *s, const duet_state *states, double lower[3], double upper[3],
                      duet_error *err)
{
    const duet_motion_def *d = s->def;
    for (uint32_t k = 0; k < d->dims; ++k) {
        if (!find_extent(s, states, k, &lower[k], &upper[k], err))
            return false;
        if (d->boundary == DUET_BOUNDARY_NONE)
            continue;
        lower[k] = fmin(lower[k], d->lower[k]);
        if (k < 2)
            upper[k] = fmax(upper[k], d->upper[k]);
    }
    return true;
}

// ---------------------------------------------------------------- colours

// From blue over green to amber.
static tint tint_at(double part)
{
    static const tint scale[] = {
        {0.19, 0.30, 0.55}, {0.17, 0.53, 0.64}, {0.42, 0.68, 0.48}, {0.93, 0.74, 0.33}};
    const int last = (int)(sizeof scale / sizeof *scale) - 1;
    double at = last * fmin(1.0, fmax(0.0, part));
    int i = at >= last ? last - 1 : (int)at;
    double t = at - i;
    const tint *a = &scale[i], *b = &scale[i + 1];
    return (tint){a->red + t * (b->red - a->red), a->green + t * (b->green - a->green),
                  a->blue + t * (b->blue - a->blue)};
}

static tint lit(tint t, double light)
{
    return (tint){light * t.red, light * t.green, light * t.blue};
}

// Where an object began: how high, or how far from what attracts.
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
                                        : lit(tint_at(part), brightness_of(i));
    }
}

// What calls for the effect `continuous`: more than half its least half extent a step.
static bool moves_fast(const duet_motion_def *d, const duet_pose *p, const duet_state *s)
{
    double speed = hypot(s->velocity[0], s->velocity[1]);
    double least = fmin(p->half_extents[0], p->half_extents[1]);
    if (d->dims == 3) {
        speed = hypot(speed, s->velocity[2]);
        least = fmin(least, p->half_extents[2]);
    }
    return speed * d->dt > 0.5 * least;
}

// Where all are that fast, as on orbits, none was shot.
static void find_shot(snapshot *s, const duet_state *start)
{
    const duet_pose *poses = duet_scene_get_objects(s->scene, DUET_OBJECT_POSES);
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n; ++i) {
        s->is_shot[i] = moves_fast(s->def, &poses[i], &start[i]);
        n += s->is_shot[i];
    }
    if (n > s->n / 2)
        memset(s->is_shot, 0, s->n * sizeof *s->is_shot);
}

bool snapshot_begin(snapshot *s, const duet_motion_def *def, const duet_scene *scene,
                    const duet_state *start, duet_error *err)
{
    *s = (snapshot){.def = def, .scene = scene, .n = duet_scene_get_info(scene)->n};
    s->colours = calloc((size_t)s->n + 1, sizeof *s->colours);
    s->is_shot = calloc((size_t)s->n + 1, sizeof *s->is_shot);
    if (!s->colours || !s->is_shot)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a picture of %u objects", s->n);
    find_shot(s, start);
    colour_objects(s, start);
    return find_part(s, start, s->lower, s->upper, err);
}

void snapshot_end(snapshot *s)
{
    free(s->colours);
    free(s->is_shot);
}

// ---------------------------------------------------------------- the eye

typedef struct eye {
    raster *on;
    double right[3], up[3], near[3];
    double scale;
    double middle[3];
} eye;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void put_unit(double to[3], const double v[3])
{
    double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; ++k)
        to[k] = v[k] / length;
}

static eye aim(raster *on, uint32_t dims, const double lower[3], const double upper[3])
{
    static const double views[2][3][3] = {
        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
        {{0.8, 0.6, 0}, {-0.27, 0.36, 0.9}, {0.54, -0.72, 0.45}},
    };
    eye e = {.on = on};
    put_unit(e.right, views[dims == 3][0]);
    put_unit(e.up, views[dims == 3][1]);
    put_unit(e.near, views[dims == 3][2]);
    double wide = 1e-9, high = 1e-9;
    for (uint32_t k = 0; k < dims; ++k) {
        e.middle[k] = 0.5 * (lower[k] + upper[k]);
        wide += fabs(e.right[k]) * (upper[k] - lower[k]);
        high += fabs(e.up[k]) * (upper[k] - lower[k]);
    }
    e.scale = 0.9 * fmin(WIDTH / wide, HEIGHT / high);
    return e;
}

static spot project(const eye *e, const double at[3])
{
    double d[3] = {at[0] - e->middle[0], at[1] - e->middle[1], at[2] - e->middle[2]};
    return (spot){0.5 * WIDTH + e->scale * dot(d, e->right),
                  0.5 * HEIGHT - e->scale * dot(d, e->up), dot(d, e->near)};
}

// ---------------------------------------------------------------- boxes

typedef struct block {
    double centre[3];
    double axis[3][3];
    double half_extents[3];
} block;

static block block_of(const duet_pose *pose, const duet_state *state, uint32_t dims)
{
    const double *q = state->rotation;
    double x = q[0], y = q[1], z = q[2], w = q[3];
    bool deep = dims == 3;
    return (block){
        {state->centre[0], state->centre[1], deep ? state->centre[2] : 0.0},
        {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
         {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
         {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}},
        {pose->half_extents[0], pose->half_extents[1], deep ? pose->half_extents[2] : 0.0},
    };
}

// One of the faces across axis k, where it is turned to the eye.
static void draw_face(const eye *e, const block *b, int k, double side, tint colour)
{
    static const double light[3] = {0.35, -0.45, 0.82};
    if (side * dot(b->axis[k], e->near) <= 0)
        return;
    int u = (k + 1) % 3, v = (k + 2) % 3;
    spot corners[4];
    for (int i = 0; i < 4; ++i) {
        double su = i == 0 || i == 3 ? 1 : -1, sv = i < 2 ? 1 : -1;
        double at[3];
        for (int j = 0; j < 3; ++j)
            at[j] = b->centre[j] + side * b->half_extents[k] * b->axis[k][j] +
                    su * b->half_extents[u] * b->axis[u][j] +
                    sv * b->half_extents[v] * b->axis[v][j];
        corners[i] = project(e, at);
    }
    tint shade = lit(colour, 0.45 + 0.6 * fmax(0.0, side * dot(b->axis[k], light)));
    const spot other[3] = {corners[0], corners[2], corners[3]};
    raster_triangle(e->on, corners, shade);
    raster_triangle(e->on, other, shade);
}

static void draw_block(const eye *e, const block *b, uint32_t dims, tint colour)
{
    for (int k = dims == 3 ? 0 : 2; k < 3; ++k) {
        draw_face(e, b, k, 1.0, colour);
        draw_face(e, b, k, -1.0, colour);
    }
}

// The floor of a world with walls; in 2D what they enclose.
static void draw_ground(const eye *e, const duet_motion_def *d)
{
    block b = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (int k = 0; k < 2; ++k) {
        b.centre[k] = 0.5 * (d->lower[k] + d->upper[k]);
        b.half_extents[k] = 0.5 * (d->upper[k] - d->lower[k]);
    }
    b.centre[2] = d->dims == 3 ? d->lower[2] : -1.0;
    if (d->boundary != DUET_BOUNDARY_NONE)
        draw_face(e, &b, 2, 1.0, ground);
}

static bool draw(const snapshot *s, const char *path, const duet_state *states,
                 const double lower[3], const double upper[3], duet_error *err)
{
    raster *on = raster_open(path, WIDTH, HEIGHT, paper, err);
    if (!on)
        return false;
    uint32_t dims = s->def->dims;
    const duet_pose *poses = duet_scene_get_objects(s->scene, DUET_OBJECT_POSES);
    eye e = aim(on, dims, lower, upper);
    draw_ground(&e, s->def);
    for (uint32_t i = 0; i < s->n; ++i) {
        block b = block_of(&poses[i], &states[i], dims);
        draw_block(&e, &b, dims, s->colours[i]);
    }
    return raster_close(on, true, err);
}

bool snapshot_frame(const snapshot *s, const char *path, const duet_state *states, duet_error *err)
{
    return draw(s, path, states, s->lower, s->upper, err);
}

bool snapshot_picture(const snapshot *s, const char *path, const duet_state *states,
                      duet_error *err)
{
    double lower[3] = {0}, upper[3] = {0};
    return find_part(s, states, lower, upper, err) && draw(s, path, states, lower, upper, err);
}
