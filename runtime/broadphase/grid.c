// SPDX-License-Identifier: MIT
#include "runtime/broadphase/grid.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Dense cell starts cost four bytes a cell; four cells an object keep them
// below a tenth of what an object itself takes.
static const double cells_per_object = 4.0;
static const double most_dense_along = 0x1p16;
static const double most_hashed_along = 0x1p30;

// A row of cells costs about as much to look up as this many objects to test.
static const double row_cost = 4.0;

// The devices' reach is wider than the boxes' by a share below 3 * 2^-18
// (kernels/narrowphase/object.clh, set_reach).
static const double devices_widen = 1.0 + 0x1p-16;

// 1 / edge is a float.
static const double least_edge_along = 0x1p-125;

// The part of the edge of so many cells that is above the widest object.
static double margin(double cells, bool dense)
{
    return 1.0 + 0x1p-16 + (dense ? cells * 0x1p-21 : 0.0);
}

// ---------------------------------------------------------------- levels

// One level on the way to a grid: how many objects, and how wide they are.
typedef struct size_class {
    double n;
    double widest;
} size_class;

typedef struct size_classes {
    size_class at[GRID_OCTAVES]; // finest first
    uint32_t n;
} size_classes;

// Tests and look-ups of all objects, were they spread evenly over the volume.
static double estimate_cost(const size_classes *classes, double volume, uint32_t dims)
{
    double rows = dims == 3 ? 5.0 : 2.0;
    double cost = 0.0;
    for (uint32_t l = 0; l < classes->n; ++l) {
        const size_class *own = &classes->at[l];
        double around = pow(3.0 * own->widest, dims) / 2.0;
        double tests = fmin(own->n * around / volume, own->n);
        double each = rows * row_cost + tests;
        for (uint32_t m = l + 1; m < classes->n; ++m) {
            const size_class *coarse = &classes->at[m];
            double reach = pow(own->widest + 2.0 * coarse->widest, dims);
            each += rows * row_cost + fmin(coarse->n * reach / volume, coarse->n);
        }
        cost += own->n * each;
    }
    return cost;
}

// Joins class i with the one after it.
static size_classes joined(const size_classes *classes, uint32_t i)
{
    size_classes fewer = *classes;
    fewer.at[i + 1].n += fewer.at[i].n;
    for (uint32_t k = i; k + 1 < fewer.n; ++k)
        fewer.at[k] = fewer.at[k + 1];
    --fewer.n;
    return fewer;
}

// Starts from a level an octave and joins neighbours while that costs less, or
// while there are too many.
static void choose_levels(size_classes *classes, double volume, uint32_t dims)
{
    double cost = estimate_cost(classes, volume, dims);
    for (;;) {
        size_classes best = *classes;
        double best_cost = classes->n > GRID_LEVELS ? INFINITY : cost;
        for (uint32_t i = 0; i + 1 < classes->n; ++i) {
            size_classes fewer = joined(classes, i);
            double fewer_cost = estimate_cost(&fewer, volume, dims);
            if (fewer_cost <= best_cost) {
                best = fewer;
                best_cost = fewer_cost;
            }
        }
        if (best.n == classes->n)
            return;
        *classes = best;
        cost = best_cost;
    }
}

static double widest_bounds(const grid_needs *needs)
{
    double widest = 0.0;
    for (uint32_t k = 0; k < GRID_OCTAVES; ++k)
        widest = fmax(widest, needs->octave_widest[k]);
    return widest;
}

static void classify(size_classes *classes, const grid_needs *needs)
{
    classes->n = 0;
    for (uint32_t k = 0; k < GRID_OCTAVES; ++k)
        if (needs->octave_n[k] > 0)
            classes->at[classes->n++] =
                (size_class){needs->octave_n[k], needs->octave_widest[k] * devices_widen};
}

// ---------------------------------------------------------------- cells

// Counts the cells that hold the edge with its margin.
static double count_along(double length, double edge, bool dense)
{
    double most = dense ? most_dense_along : most_hashed_along;
    if (!(edge > 0.0))
        return length > 0.0 ? most : 1.0;
    double about = fmin(length / edge, most);
    return fmax(1.0, fmin(floor(length / (edge * margin(about, dense))), most));
}

static double count_cells(const double length[3], double edge)
{
    double total = 1.0;
    for (int k = 0; k < 3; ++k)
        total *= count_along(length[k], edge, true);
    return total;
}

// Widens the level with the most cells until all levels together have few
// enough; one that has become as wide as the next takes its objects over.
static void limit_cells(double edges[], uint32_t *n_levels, const double length[3], double most)
{
    for (;;) {
        double total = 0.0;
        double largest = -1.0;
        uint32_t widen = 0;
        for (uint32_t l = 0; l < *n_levels; ++l) {
            double cells = count_cells(length, edges[l]);
            total += cells;
            if (cells > largest) {
                largest = cells;
                widen = l;
            }
        }
        if (total <= most)
            return;
        double longest = fmax(length[0], fmax(length[1], length[2]));
        edges[widen] = fmax(edges[widen] * 1.05, longest / most_dense_along);
        while (widen + 1 < *n_levels && edges[widen] >= edges[widen + 1]) {
            for (uint32_t l = widen + 1; l + 1 < *n_levels; ++l)
                edges[l] = edges[l + 1];
            --*n_levels;
        }
    }
}

// Without origin cells the corner is a coordinate; else it is one in its cell,
// which is kept where the kernels look for it (kernels/grid/grid.clh).
static void set_corner(grid_level *level, uint32_t axis, double lower, float origin)
{
    cl_float *cells[] = {&level->lower.s[3], &level->per_cell.s[3], &level->limit.s[3]};
    double cell = origin > 0.0f ? floor(lower / origin) : 0.0;
    cell = fmax(-0x1p30 + 1, fmin(cell, 0x1p30 - 1));
    cl_int whole = (cl_int)cell;
    double offset = lower - cell * origin;
    if (origin > 0.0f) // whole quanta, so that its distance to any offset is a float
        offset = floor(offset * (0x1p24 / origin)) * (origin * 0x1p-24);
    level->lower.s[axis] = (cl_float)offset;
    memcpy(cells[axis], &whole, sizeof whole);
}

double grid_corner(const grid_level *level, float origin, uint32_t axis)
{
    const cl_float *cells[] = {&level->lower.s[3], &level->per_cell.s[3], &level->limit.s[3]};
    cl_int whole;
    memcpy(&whole, cells[axis], sizeof whole);
    return (double)whole * origin + (double)level->lower.s[axis];
}

// An object that fits reaches this far beyond its point. Twice the margin is for
// what rounding does to both ends if positions are in origin cells.
static float reach_of(double along, double limit, duet_shape shape)
{
    double reach = shape == DUET_SHAPE_BOUNDS ? limit : limit / 2;
    return (cl_float)(reach + 2 * (along - limit));
}

static grid_level make_level(const double lower[3], const double length[3], double edge, bool dense,
                             const grid_objects *o)
{
    grid_level level = {.cells = {{1, 1, 1, 0}}};
    for (uint32_t k = 0; k < o->dims; ++k) {
        double cells = count_along(length[k], edge, dense);
        double slack = margin(cells, dense);
        double along = fmax(length[k] / cells, edge * slack);
        if (along == 0.0) // points in one place
            along = 1.0;
        along = fmax(along, least_edge_along);
        level.cells.s[k] = (cl_int)cells;
        set_corner(&level, k, lower[k], o->origin);
        level.per_cell.s[k] = (cl_float)(1.0 / along);
        bool fits_all = cells == 1.0;
        level.limit.s[k] = fits_all ? INFINITY : (cl_float)(along / slack);
        level.reach.s[k] = fits_all ? INFINITY : reach_of(along, along / slack, o->shape);
    }
    return level;
}

static float least_edge(const grid_level *level, uint32_t dims)
{
    float edge = INFINITY;
    for (uint32_t k = 0; k < dims; ++k)
        edge = fminf(edge, 1.0f / level->per_cell.s[k]);
    return edge;
}

static void set_key_bits(grid *g)
{
    g->key_bits = 0;
    while (g->key_bits < 32 && g->n_cells >> g->key_bits)
        ++g->key_bits;
}

static grid make_dense(const double lower[3], const double length[3], const size_classes *classes,
                       const grid_objects *o)
{
    double edges[GRID_LEVELS];
    grid g = {.kind = GRID_DENSE, .n_levels = classes->n};
    for (uint32_t l = 0; l < g.n_levels; ++l)
        edges[l] = classes->at[l].widest;
    limit_cells(edges, &g.n_levels, length, fmin(cells_per_object * o->all.n + 64.0, 0x1p31));
    for (uint32_t l = 0; l < g.n_levels; ++l) {
        g.levels[l] = make_level(lower, length, edges[l], true, o);
        const cl_int *cells = g.levels[l].cells.s;
        g.levels[l].cells.s[3] = (cl_int)g.n_cells;
        g.n_cells += (uint32_t)cells[0] * (uint32_t)cells[1] * (uint32_t)cells[2];
    }
    g.edge = least_edge(&g.levels[0], o->dims);
    set_key_bits(&g);
    return g;
}

static grid make_hashed(const double lower[3], const double length[3], const size_classes *classes,
                        const grid_objects *o)
{
    grid g = {.kind = GRID_HASHED, .n_levels = classes->n, .n_cells = 1024};
    while (g.n_cells < 0x80000000u && g.n_cells < 2 * (uint64_t)o->all.n)
        g.n_cells *= 2;
    for (uint32_t l = 0; l < g.n_levels; ++l)
        g.levels[l] = make_level(lower, length, classes->at[l].widest, false, o);
    g.edge = least_edge(&g.levels[0], o->dims);
    set_key_bits(&g);
    return g;
}

// ---------------------------------------------------------------- crowds

// A coordinate's cell along one axis of a dense grid, in the kernels' own float
// arithmetic: what is not a number lies in the first.
static inline uint32_t cell_along(float at, float lower, float per_cell, cl_int cells)
{
    float last = (float)(cells - 1);
    float cell = (at - lower) * per_cell;
    cell = cell > 0.0f ? cell : 0.0f;
    return (uint32_t)(int32_t)(cell < last ? cell : last);
}

// Along an axis those of n objects from `first` on, as fast as they are read; as the kernels have
// them, but for rounding with origin cells.
static void find_cells_along(uint32_t *cells, const grid *g, const grid_objects *objects,
                             uint32_t first, uint32_t n, uint32_t axis)
{
    const grid_level *level = &g->levels[0];
    const size_t bytes = objects->all.row_bytes;
    const char *rows = (const char *)objects->all.rows + first * bytes;
    float lower = level->lower.s[axis], per_cell = level->per_cell.s[axis];
    cl_int along = level->cells.s[axis];
    if (objects->origin > 0.0f) {
        double corner = grid_corner(level, objects->origin, axis);
        for (uint32_t k = 0; k < n; ++k) {
            const duet_large_pose *row = (const void *)(rows + k * bytes);
            double at = (double)row->cell[axis] * objects->origin + (double)row->pose.centre[axis];
            cells[k] = cell_along((float)(at - corner), 0, per_cell, along);
        }
        return;
    }
    const char *at = rows + axis * sizeof(float);
    for (uint32_t k = 0; k < n; ++k)
        cells[k] = cell_along(*(const float *)(at + k * bytes), lower, per_cell, along);
}

void grid_cell_of(uint32_t cell[3], const grid *g, const grid_objects *objects, uint32_t id)
{
    cell[2] = 0;
    for (uint32_t k = 0; k < objects->dims; ++k)
        find_cells_along(&cell[k], g, objects, id, 1, k);
}

void grid_cell_rows(uint32_t *rows, const grid *g, const grid_objects *objects, uint32_t first,
                    uint32_t n)
{
    uint32_t layers[GRID_BLOCK];
    find_cells_along(rows, g, objects, first, n, 1);
    if (objects->dims == 2)
        return;
    find_cells_along(layers, g, objects, first, n, 2);
    for (uint32_t k = 0; k < n; ++k)
        rows[k] += layers[k] * (uint32_t)g->levels[0].cells.s[1];
}

// Bounds that end before they begin: bad ones, which no search takes.
static bool is_left_out(const grid_objects *objects, uint32_t id)
{
    const duet_bounds *b = &((const duet_bounds *)objects->all.rows)[id];
    bool left_out = false;
    for (uint32_t k = 0; objects->shape == DUET_SHAPE_BOUNDS && k < objects->dims; ++k)
        left_out |= b->upper[k] < b->lower[k];
    return left_out;
}

// The mean number of others in an object's cell of the finest level.
static bool count_crowd(double *others, const grid *g, const grid_objects *objects, duet_error *err)
{
    const grid_level *level = &g->levels[0];
    uint32_t nx = (uint32_t)level->cells.s[0], ny = (uint32_t)level->cells.s[1];
    size_t cells = (size_t)nx * ny * (uint32_t)level->cells.s[2];
    uint32_t *counts = calloc(cells, sizeof *counts);
    if (!counts)
        return no_memory(err, "the counts of %zu cells", cells);
    for (uint32_t id = 0; id < objects->all.n; ++id) {
        uint32_t cell[3];
        if (is_left_out(objects, id))
            continue;
        grid_cell_of(cell, g, objects, id);
        ++counts[((size_t)cell[2] * ny + cell[1]) * nx + cell[0]];
    }
    double pairs = 0.0;
    for (size_t c = 0; c < cells; ++c)
        pairs += (double)counts[c] * ((double)counts[c] - 1.0);
    free(counts);
    *others = pairs / objects->all.n;
    return true;
}

// ---------------------------------------------------------------- fit

// The corner and the lengths of the grid: a point at the origin if there are no objects.
static void place_world(double lower[3], double length[3], const grid_needs *needs,
                        const grid_wish *wish, uint32_t dims)
{
    for (uint32_t k = 0; k < 3; ++k) {
        double from = wish->lower ? (double)wish->lower[k] : needs->lower[k];
        double to = wish->upper ? (double)wish->upper[k] : needs->upper[k];
        bool there = k < dims && from <= to;
        lower[k] = there ? from : 0.0;
        length[k] = there ? to - from : 0.0;
    }
}

bool grid_fit(grid *g, const grid_needs *needs, const grid_wish *wish, const grid_objects *objects,
              duet_error *err)
{
    uint32_t dims = objects->dims;
    double lower[3];
    double length[3];
    place_world(lower, length, needs, wish, dims);
    size_classes classes;
    classify(&classes, needs);
    if (wish->n_levels == 1 || wish->edge > 0.0 || classes.n == 0) {
        classes.at[0] =
            (size_class){objects->all.n, fmax(wish->edge, widest_bounds(needs) * devices_widen)};
        classes.n = 1;
    } else {
        double volume = 1.0;
        for (uint32_t k = 0; k < dims; ++k)
            volume *= fmax(length[k], needs->widest);
        choose_levels(&classes, volume, dims);
    }
    if (wish->kinds == GRID_ONLY_HASHED) {
        *g = make_hashed(lower, length, &classes, objects);
        return true;
    }
    *g = make_dense(lower, length, &classes, objects);
    bool coarser = g->n_levels < classes.n || (double)g->edge > 2.0 * classes.at[0].widest;
    double others = 0.0;
    if (!coarser || wish->kinds == GRID_ONLY_DENSE)
        return true;
    if (!count_crowd(&others, g, objects, err))
        return false;
    if (others > (wish->crowd ? wish->crowd : GRID_CROWD))
        *g = make_hashed(lower, length, &classes, objects);
    return true;
}
