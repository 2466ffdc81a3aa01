// SPDX-License-Identifier: MIT
// Extents and corners are taken from all objects, for one giant among a million
// matters. How they crowd is told from a sample, which takes no time.
#include "runtime/broadphase/workload_stats.h"

#include "base/budget.h"
#include "base/compare.h"
#include "runtime/broadphase/world.h"
#include "runtime/narrowphase/origin.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SAMPLED = 65536, SAMPLED_A_CELL = 16, MOST_CELLS = MOST_SAMPLED / SAMPLED_A_CELL };

// Rows that are sorted to tell how many objects stray.
enum { MOST_ROWS = 4096 };

static inline void widen(float *lower, float *upper, float at)
{
    *lower = at < *lower ? at : *lower;
    *upper = at > *upper ? at : *upper;
}

// Axis by axis, so that what is known so far stays in registers.
static inline void see_object(workload_stats *c, float x, float y, float z, float size)
{
    widen(&c->lower[0], &c->upper[0], x);
    widen(&c->lower[1], &c->upper[1], y);
    widen(&c->lower[2], &c->upper[2], z);
    c->widest = size > c->widest ? size : c->widest;
    c->narrowest = size > 0 && size < c->narrowest ? size : c->narrowest;
}

static inline float larger(float a, float b)
{
    return a > b ? a : b;
}

static inline float size_of_pose(const duet_pose *p, const duet_world_def *def)
{
    float x = p->half_extents[0], y = p->half_extents[1],
          z = def->dims == 3 ? p->half_extents[2] : 0;
    return def->rotated ? x * x + y * y + z * z : larger(larger(x, y), z);
}

static void see_bounds(workload_stats *c, const duet_bounds *b, uint32_t dims)
{
    float sides[3] = {0}, centre[3] = {0};
    for (uint32_t k = 0; k < dims; ++k) {
        sides[k] = b->upper[k] - b->lower[k];
        centre[k] = b->lower[k] + sides[k] / 2;
    }
    see_object(c, centre[0], centre[1], centre[2], larger(larger(sides[0], sides[1]), sides[2]));
}

// A radius counts on top of a core's half diagonal, or longest half side.
static void see_box(workload_stats *c, const duet_world *world, uint32_t id)
{
    const grid_objects *objects = &world->objects;
    const bool rotated = world->def.rotated;
    duet_pose scratch;
    double corner[3] = {0};
    const duet_pose *p = grid_pose_of(objects, id, &scratch);
    float size = size_of_pose(p, &world->def);
    if (grid_has_radii(objects)) {
        size = (rotated ? sqrtf(size) : size) + grid_radius_of(objects, id);
        size = rotated ? size * size : size;
    }
    if (objects->origin > 0)
        origin_corner(corner, objects->all.rows, objects->origin, id);
    see_object(c, (float)(corner[0] + p->centre[0]), (float)(corner[1] + p->centre[1]),
               (float)(corner[2] + p->centre[2]), size);
}

static workload_stats see_range(workload_stats c, const duet_world *world, uint64_t first,
                                uint64_t end)
{
    for (uint32_t id = (uint32_t)first; id < end; ++id)
        if (world->def.shape == DUET_SHAPE_BOUNDS)
            see_bounds(&c, (const duet_bounds *)world->objects.all.rows + id, world->def.dims);
        else
            see_box(&c, world, id);
    return c;
}

// Takes seconds for many millions of objects, and tells how far it is.
static workload_stats see_all(const duet_world *world)
{
    enum { AT_ONCE = 1 << 18 };
    const uint32_t n = world->objects.all.n;
    workload_stats c = {.n = n,
                        .lower = {FLT_MAX, FLT_MAX, FLT_MAX},
                        .upper = {-FLT_MAX, -FLT_MAX, -FLT_MAX},
                        .narrowest = FLT_MAX};
    for (uint64_t first = 0; first < n; first += AT_ONCE) {
        budget_tell(first, n);
        c = see_range(c, world, first, first + AT_ONCE < n ? first + AT_ONCE : n);
    }
    return c;
}

// Extents are diagonals of boxes that may be turned, else longest sides.
static float extent_of(const duet_world_def *def, float size)
{
    if (def->shape == DUET_SHAPE_BOUNDS)
        return size;
    return 2 * (def->rotated ? sqrtf(size) : size);
}

// The cells that the scene asks for.
typedef struct raster {
    double lower[3];
    double edge[3];
    uint32_t cells[3];
} raster;

static raster lay_raster(const duet_world_def *def, const workload_stats *c)
{
    raster r = {.cells = {1, 1, 1}};
    double edge = fmax(def->cell, extent_of(def, c->widest));
    for (uint32_t k = 0; k < def->dims; ++k) {
        r.lower[k] = def->has_world ? def->lower[k] : c->lower[k];
        double upper = def->has_world ? def->upper[k] : c->upper[k];
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

static uint32_t cell_along(const raster *r, const double centre[3], int axis)
{
    double along = r->edge[axis] > 0 ? (centre[axis] - r->lower[axis]) / r->edge[axis] : 0;
    uint32_t last = r->cells[axis] - 1;
    return along > 0 ? (uint32_t)(along < last ? along : last) : 0;
}

static uint32_t cell_of(const raster *r, const double centre[3])
{
    uint32_t cell = 0;
    for (int k = 3; k-- > 0;)
        cell = cell * r->cells[k] + cell_along(r, centre, k);
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
    uint32_t stride = 1 + (world->objects.all.n - 1) / MOST_SAMPLED;
    uint32_t n = 1 + (world->objects.all.n - 1) / stride;
    raster r = coarsen(*fine, fmax(1, n / SAMPLED_A_CELL));
    uint32_t counts[MOST_CELLS] = {0};
    for (uint64_t id = 0; id < world->objects.all.n; id += stride) {
        double centre[3] = {0};
        grid_centre_of(centre, &world->objects, (uint32_t)id);
        ++counts[cell_of(&r, centre)];
    }
    double coarse = count_cells(&r);
    return fullest_hundredth(counts, (uint32_t)coarse) * world->objects.all.n / n /
           (count_cells(fine) / coarse);
}

// The rows of a sample, in the order of the objects.
static uint32_t sample_rows(double rows[MOST_ROWS], const duet_world *world, const raster *r)
{
    uint32_t stride = 1 + (world->objects.all.n - 1) / MOST_ROWS;
    uint32_t n = 0;
    for (uint64_t id = 0; id < world->objects.all.n; id += stride) {
        double centre[3] = {0};
        grid_centre_of(centre, &world->objects, (uint32_t)id);
        rows[n++] = (double)cell_along(r, centre, 2) * r->cells[1] + cell_along(r, centre, 1);
    }
    return n;
}

static double count_strays(const duet_world *world, const raster *r)
{
    double rows[MOST_ROWS], sorted[MOST_ROWS];
    uint32_t n = sample_rows(rows, world, r);
    memcpy(sorted, rows, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare_double);
    double middle = sorted[n / 2];
    uint32_t n_strays = 0;
    for (uint32_t i = 0; i < n; ++i)
        n_strays += i < n / 2 ? rows[i] > middle : rows[i] < middle;
    return (double)n_strays / n;
}

void workload_stats_take(workload_stats *c, const duet_world *world)
{
    *c = see_all(world);
    raster r = lay_raster(&world->def, c);
    c->crowding = crowding(world, &r);
}

workload_summary workload_summarise(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    workload_stats c = world->stats;
    if (c.n == 0 || world->def.pose_form)
        workload_stats_take(&c, world);
    raster r = lay_raster(def, &c);
    float widest = extent_of(def, c.widest), narrowest = extent_of(def, c.narrowest);
    return (workload_summary){
        .cells = {r.cells[0], r.cells[1], r.cells[2]},
        .cell = r.edge[0],
        .mean_occupancy = world->objects.all.n / count_cells(&r),
        .crowding = c.crowding,
        .size_ratio = widest > narrowest ? widest / narrowest : 1,
        .strays = def->ordered ? count_strays(world, &r) : 0,
    };
}
