// SPDX-License-Identifier: MIT
// The grid that suits a world's objects, and the mode that suits the grid.
#include "runtime/broadphase/world.h"

#include "base/error.h"

#include <string.h>

// Grids are fitted again where the number of objects has changed this much.
enum { REFIT_FACTOR = 2 };

// Which mode the default is depends on the grid, which slabs cut only where its cells are
// of one size. To have them at any price was measured three times slower where sizes are mixed.
void world_choose_mode(duet_world *world)
{
    bool one_size = world->grid.kind == GRID_DENSE && world->grid.n_levels == 1;
    if (world->mode_open)
        world->def.plan.mode = one_size && world->alike ? DUET_MODE_SLAB : DUET_MODE_OWN;
}

// The grid is another than the one before.
static void take_grid(duet_world *world, const grid *before, uint32_t n)
{
    const cl_int4 was = before->levels[0].cells, is = world->grid.levels[0].cells;
    world->cells_vary |= was.s[0] > 0 && memcmp(&was, &is, sizeof is) != 0;
    world->fitted = true;
    world->fitted_n = n;
    world_choose_mode(world);
    world->split.stale = true;
    ++world->grid_version;
}

void world_swap_fit(duet_world *world, world_fit *fit)
{
    world_fit before = {world->fitted, world->cell_widened, world->fitted_n, world->grid};
    world->fitted = fit->fitted;
    world->cells_vary = true;
    if (fit->fitted) {
        world->grid = fit->grid;
        world->cell_widened = fit->cell_widened;
        take_grid(world, &before.grid, fit->n);
    }
    *fit = before;
}

// The next step fits another one, which is no change of this one.
void world_forget_grid(duet_world *world)
{
    world->fitted = world->cells_vary = false;
    world->grid = (grid){0};
}

static bool is_fitted(const duet_world *world)
{
    uint64_t n = world->n;
    return n == 0 || (world->fitted && n <= REFIT_FACTOR * (uint64_t)world->fitted_n &&
                      REFIT_FACTOR * n >= world->fitted_n);
}

static grid_wish wish_of(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    grid_wish wish = world->wish;
    wish.has_world = def->has_world;
    wish.edge = def->cell;
    wish.by_gpus = true;
    for (int side = 0; side < 2; ++side)
        wish.by_gpus &= world->parts[side].device->info.kind == DUET_KIND_GPU;
    for (int k = 0; k < 3; ++k) {
        wish.lower[k] = def->lower[k];
        wish.upper[k] = def->upper[k];
    }
    return wish;
}

bool world_fit_grid(duet_world *world, grid_objects *objects, bool seen, thread_pool *threads,
                    duet_error *err)
{
    const duet_world_def *def = &world->def;
    const bool fitted = is_fitted(world);
    const bool cuts = def->plan.mode == DUET_MODE_SLAB && world->split.stale;
    const grid_wish wish = wish_of(world);
    if (!world_take_objects(world, seen || !fitted || cuts, err))
        return false;
    *objects = world_objects(world);
    if (fitted)
        return true;
    const grid before = world->grid;
    grid_needs needs;
    grid_needs_of(&needs, objects, threads);
    bool too_small = def->cell > 0.0f && needs.widest > def->cell;
    if (too_small && def->cell_fixed)
        return error_set(err, DUET_STATUS_CELL_TOO_SMALL,
                         "the cell edge %g is below the extent %.9g of object %u; expected a "
                         "cell at least that wide",
                         def->cell, needs.widest, needs.widest_id);
    if (!grid_fit(&world->grid, &needs, &wish, objects, err))
        return false;
    world->cell_widened = too_small;
    take_grid(world, &before, world->n);
    return true;
}
