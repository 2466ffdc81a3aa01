// SPDX-License-Identifier: MIT
#include "runtime/queries/item_draw.h"

#include "base/error.h"
#include "base/rng.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/queries/far_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct draw {
    rng random;
    uint32_t dims;
    const char *objects;
    duet_shape shape;
    float edge;   // the edge of origin cells, or 0
    size_t width; // bytes of an object
    uint32_t n_objects;
    double lower[3], upper[3];
} draw;

// All but bounds begin with their centre.
static double middle_of(const draw *d, uint32_t i, uint32_t k)
{
    const float *row = (const float *)(d->objects + i * d->width);
    double corner[3];
    origin_corner(corner, d->objects, d->edge, i);
    return d->shape == DUET_SHAPE_BOUNDS ? 0.5 * row[k] + 0.5 * row[3 + k] : corner[k] + row[k];
}

static void measure_extent(draw *d)
{
    for (int k = 0; k < 3; ++k) {
        d->lower[k] = INFINITY;
        d->upper[k] = -INFINITY;
    }
    for (uint32_t i = 0; i < d->n_objects; ++i)
        for (uint32_t k = 0; k < d->dims; ++k) {
            double at = middle_of(d, i, k);
            d->lower[k] = fmin(d->lower[k], at);
            d->upper[k] = fmax(d->upper[k], at);
        }
}

// cell is written in origin cells only.
static void draw_point(draw *d, float at[3], int32_t cell[3])
{
    duet_large_pose large = {0};
    double place[3];
    for (uint32_t k = 0; k < 3; ++k) {
        place[k] = k < d->dims ? rng_between(&d->random, d->lower[k], d->upper[k]) : 0;
        at[k] = (float)place[k];
    }
    if (d->edge == 0)
        return;
    origin_place(&large, place, d->edge);
    memcpy(at, large.pose.centre, sizeof large.pose.centre);
    memcpy(cell, large.cell, sizeof large.cell);
}

// Draws a direction of length 1.
static void draw_direction(draw *d, float direction[3])
{
    double v[3] = {0}, length = 0;
    for (uint32_t k = 0; k < d->dims; ++k) {
        v[k] = rng_normal(&d->random);
        length += v[k] * v[k];
    }
    for (int k = 0; k < 3; ++k)
        direction[k] = (float)(v[k] / sqrt(length));
}

// An item that lists all it meets goes an eighth of the way through.
static float draw_end(const draw *d, duet_query_wants wants)
{
    double widest = 0;
    for (uint32_t k = 0; k < d->dims; ++k)
        widest = fmax(widest, d->upper[k] - d->lower[k]);
    return wants == DUET_QUERY_EVERY ? (float)(widest / 8) : INFINITY;
}

static void draw_ray(draw *d, const query_name *name, void *item)
{
    duet_large_ray *large = item; // its first part is a ray
    draw_point(d, large->ray.origin, large->cell);
    draw_direction(d, large->ray.direction);
    large->ray.t_max = draw_end(d, name->wants);
}

static void draw_at(draw *d, const query_name *name, void *item)
{
    (void)name;
    duet_large_point *large = item;
    draw_point(d, large->point.at, large->cell);
}

// One of the objects, elsewhere.
static void draw_box(draw *d, const query_name *name, void *item)
{
    float at[3];
    int32_t cell[3];
    uint32_t i = rng_below(&d->random, d->n_objects);
    float *row = item;
    (void)name;
    draw_point(d, at, cell);
    memcpy(row, d->objects + i * d->width, d->width);
    if (d->edge > 0)
        memcpy(row + FAR_POSE_CELL, cell, sizeof cell);
    for (uint32_t k = 0; k < d->dims; ++k) {
        if (d->shape == DUET_SHAPE_BOUNDS)
            row[3 + k] = at[k] + (row[3 + k] - row[k]);
        row[k] = at[k];
    }
}

static void draw_sweep(draw *d, const query_name *name, void *item)
{
    float *way =
        d->edge > 0 ? ((duet_large_sweep *)item)->direction : (float *)((char *)item + d->width);
    draw_box(d, name, item);
    draw_direction(d, way);
    way[3] = draw_end(d, name->wants);
}

static size_t item_bytes(const draw *d, query_item item)
{
    switch (item) {
    case QUERY_RAYS:
        return d->edge > 0 ? sizeof(duet_large_ray) : sizeof(duet_ray);
    case QUERY_SWEEPS:
        return d->edge > 0 ? sizeof(duet_large_sweep) : d->width + 4 * sizeof(float);
    case QUERY_BOXES:
        return d->width;
    case QUERY_POINTS:
        return d->edge > 0 ? sizeof(duet_large_point) : sizeof(duet_point);
    }
    return 0;
}

void *item_draw(const query_name *name, uint64_t n, const item_objects *among, uint64_t seed,
                duet_error *err)
{
    static void (*const draws[])(draw *, const query_name *, void *) = {
        [QUERY_RAYS] = draw_ray,
        [QUERY_SWEEPS] = draw_sweep,
        [QUERY_BOXES] = draw_box,
        [QUERY_POINTS] = draw_at,
    };
    draw d = {.random = rng_seed(seed),
              .dims = among->dims,
              .objects = among->rows,
              .shape = among->shape,
              .edge = among->origin_edge,
              .width = origin_row_bytes(among->shape, among->origin_edge),
              .n_objects = among->n};
    size_t bytes = item_bytes(&d, name->item);
    char *items = calloc(n, bytes);
    measure_extent(&d);
    for (uint64_t i = 0; items && i < n; ++i)
        draws[name->item](&d, name, items + i * bytes);
    return items ? items : null_no_memory(err, "%llu items", (unsigned long long)n);
}
