// SPDX-License-Identifier: MIT
// Extents and corners are taken from all objects, for one giant among a million
// matters. How they crowd is told from a sample, which takes no time.
#include "runtime/census.h"

#include "runtime/origin.h"

#include <float.h>
#include <math.h>

enum { MOST_SAMPLED = 65536, SAMPLED_A_CELL = 16, MOST_CELLS = MOST_SAMPLED / SAMPLED_A_CELL };

// Of all objects. What is not a number is passed over: no comparison holds.
typedef struct extremes {
    float lower[3]; // of the centres
    float upper[3];
    float widest;    // extents: diagonals of boxes that may be turned, else longest sides
    float narrowest; // above 0
} extremes;

static void see_object(extremes *e, const float centre[3], float extent, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k) {
        e->lower[k] = centre[k] < e->lower[k] ? centre[k] : e->lower[k];
        e->upper[k] = centre[k] > e->upper[k] ? centre[k] : e->upper[k];
    }
    e->widest = extent > e->widest ? extent : e->widest;
    e->narrowest = extent > 0 && extent < e->narrowest ? extent : e->narrowest;
}

static float pose_extent(const duet_pose *p, bool rotated, uint32_t dims)
{
    float longest = 0, squares = 0;
    for (uint32_t k = 0; k < dims; ++k) {
        longest = p->half[k] > longest ? p->half[k] : longest;
        squares += p->half[k] * p->half[k];
    }
    return 2 * (rotated ? sqrtf(squares) : longest);
}

static void see_pose(extremes *e, const grid_objects *objects, uint32_t id, bool rotated)
{
    duet_pose room;
    const duet_pose *pose = grid_pose_of(objects, id, &room);
    double corner[3];
    float centre[3];
    origin_corner(corner, objects->rows, objects->origin, id);
    for (int k = 0; k < 3; ++k)
        centre[k] = (float)(corner[k] + pose->centre[k]);
    see_object(e, centre, pose_extent(pose, rotated, objects->dims), objects->dims);
}

static void see_bounds(extremes *e, const duet_bounds *b, uint32_t dims)
{
    float centre[3] = {0}, longest = 0;
    for (uint32_t k = 0; k < dims; ++k) {
        float side = b->upper[k] - b->lower[k];
        centre[k] = b->lower[k] + side / 2;
        longest = side > longest ? side : longest;
    }
    see_object(e, centre, longest, dims);
}

static extremes see_all(const duet_world *world)
{
    extremes e = {.lower = {FLT_MAX, FLT_MAX, FLT_MAX},
                  .upper = {-FLT_MAX, -FLT_MAX, -FLT_MAX},
                  .narrowest = FLT_MAX};
    const duet_world_def *def = &world->def;
    grid_objects objects = world_objects(world);
    const duet_bounds *bounds = world->objects.bytes;
    for (uint32_t i = 0; i < world->n; ++i) {
        if (def->shape == DUET_SHAPE_POSES)
            see_pose(&e, &objects, i, def->rotated);
        else
            see_bounds(&e, &bounds[i], def->dims);
    }
    return e;
}

// The cells that the scene asks for.
typedef struct raster {
    double lower[3];
    double edge[3];
    uint32_t cells[3];
} raster;

static raster lay_raster(const duet_world_def *def, const extremes *e)
{
    raster r = {.cells = {1, 1, 1}};
    double edge = fmax(def->cell, e->widest);
    for (uint32_t k = 0; k < def->dims; ++k) {
        r.lower[k] = def->has_world ? def->lower[k] : e->lower[k];
        double upper = def->has_world ? def->upper[k] : e->upper[k];
        double along = edge > 0 ? ceil((upper - r.lower[k]) / edge) : 1;
        r.edge[k] = edge;
        r.cells[k] = (uint32_t)fmin(fmax(along, 1), 0x1p30);
    }
    return r;
}

static double count_cells(const raster *r)
{
    return (double)r->cells[0] * r->cells[1] * r->cells[2];
}

// Cells twice as wide along the longest axis, until there are few enough.
static raster coarsen(raster r, double most)
{
    while (count_cells(&r) > most) {
        int longest = 0;
        for (int k = 1; k < 3; ++k)
            longest = r.cells[k] > r.cells[longest] ? k : longest;
        r.cells[longest] = (r.cells[longest] + 1) / 2;
        r.edge[longest] *= 2;
    }
    return r;
}

static uint32_t cell_of(const raster *r, const double centre[3])
{
    uint32_t cell = 0;
    for (int k = 3; k-- > 0;) {
        double along = r->edge[k] > 0 ? (centre[k] - r->lower[k]) / r->edge[k] : 0;
        cell = cell * r->cells[k] + (along > 0 ? (uint32_t)fmin(along, r->cells[k] - 1.0) : 0);
    }
    return cell;
}

// How many of the counts' objects lie in a cell where the fullest hundredth of
// the cells begins.
static double fullest_hundredth(const uint32_t *counts, uint32_t n)
{
    uint32_t cells_with[MOST_CELLS + 1] = {0};
    for (uint32_t i = 0; i < n; ++i)
        ++cells_with[counts[i] < MOST_CELLS ? counts[i] : MOST_CELLS];
    uint32_t count = MOST_CELLS;
    uint32_t fuller = cells_with[count];
    while (count > 0 && fuller * 100 < n)
        fuller += cells_with[--count];
    return count;
}

// Objects in a cell there, by a sample in coarser cells.
static double crowding(const duet_world *world, const raster *fine)
{
    uint32_t stride = 1 + (world->n - 1) / MOST_SAMPLED;
    uint32_t n = 1 + (world->n - 1) / stride;
    raster r = coarsen(*fine, fmax(1, n / SAMPLED_A_CELL));
    uint32_t counts[MOST_CELLS] = {0};
    grid_objects objects = world_objects(world);
    for (uint64_t id = 0; id < world->n; id += stride) {
        double centre[3] = {0};
        grid_centre_of(centre, &objects, (uint32_t)id);
        ++counts[cell_of(&r, centre)];
    }
    double coarse = count_cells(&r);
    return fullest_hundredth(counts, (uint32_t)coarse) * world->n / n /
           (count_cells(fine) / coarse);
}

profile_workload census(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    extremes e = see_all(world);
    raster r = lay_raster(def, &e);
    bool poses = def->shape == DUET_SHAPE_POSES;
    return (profile_workload){
        .dims = def->dims,
        .n = world->n,
        .cells = {r.cells[0], r.cells[1], r.cells[2]},
        .cell = r.edge[0],
        .occ_mean = world->n / count_cells(&r),
        .occ_p99 = crowding(world, &r),
        .size_ratio = e.widest > e.narrowest ? e.widest / e.narrowest : 1,
        .shape = poses ? "poses" : "bounds",
        .rotated = poses && def->rotated,
        .level = duet_level_describe(def->level)->name,
    };
}
