// SPDX-License-Identifier: MIT
// The grid that suits a world's objects, and the mode that suits the grid.
#include "runtime/broadphase/world.h"

#include "base/error.h"

#include <string.h>

// Grids are fitted again if the number of objects has changed this much.
enum { REFIT_FACTOR = 2 };

// How unequal devices compare is not known before it is measured.
bool world_pair_is_alike(const duet_device_pair *pair)
{
    const duet_device_info *a = &pair->devices[0].info, *b = &pair->devices[1].info;
    return a->kind == b->kind && strcmp(a->name, b->name) == 0 && !duet_device_pair_is_one(pair);
}

// Slabs cut only a grid whose cells are of one size. To have them at any price was measured three
// times slower if sizes are mixed.
void world_choose_mode(duet_world *world)
{
    bool one_size = world->grid.kind == GRID_DENSE && world->grid.n_levels == 1;
    bool slabs = one_size && world_pair_is_alike(world->def.pair);
    world->def.plan.mode = world->asked_mode != DUET_MODE_DEFAULT ? world->asked_mode
                           : slabs                                ? DUET_MODE_SLAB
                                                                  : DUET_MODE_OWN;
}

// Makes a grid that was fitted to n objects the world's.
static void take_grid(duet_world *world, const grid *fitted, uint32_t n)
{
    const cl_int4 was = world->grid.levels[0].cells, is = fitted->levels[0].cells;
    const bool other = was.s[0] > 0 && memcmp(&was, &is, sizeof is) != 0;
    const bool varies = world->grid.varies || other;
    world->grid = *fitted;
    world->grid.varies = varies;
    world->fitted_n = n;
    split_forget(&world->split);
    for (int side = 0; side < 2; ++side)
        part_forget_grid(&world->parts[side]);
    world_choose_mode(world);
}

void world_swap_fit(duet_world *world, world_fit *fit)
{
    const world_fit before = {world->fitted_n, world->grid};
    world->fitted_n = 0;
    world->grid.varies = true;
    if (fit->n > 0)
        take_grid(world, &fit->grid, fit->n);
    *fit = before;
}

// The next step fits another grid, which does not count as a change of this one.
void world_forget_grid(duet_world *world)
{
    world->fitted_n = 0;
    world->grid = (grid){0};
}

void world_refit_grid(duet_world *world)
{
    world->fitted_n = 0;
}

static bool is_fitted(const duet_world *world)
{
    const uint64_t n = world->objects.all.n, fitted = world->fitted_n;
    return n == 0 || (fitted > 0 && n <= REFIT_FACTOR * fitted && REFIT_FACTOR * n >= fitted);
}

static grid_wish wish_of(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    grid_wish wish = world->wish;
    bool gpus = true;
    for (int side = 0; side < 2; ++side)
        gpus &= world->parts[side].device->info.kind == DUET_KIND_GPU;
    wish.lower = def->has_world ? def->lower : NULL;
    wish.upper = def->has_world ? def->upper : NULL;
    wish.edge = def->cell;
    wish.crowd = gpus ? GRID_CROWD_OF_GPUS : GRID_CROWD;
    return wish;
}

bool world_fit_grid(duet_world *world, bool seen, thread_pool *threads, duet_error *err)
{
    const duet_world_def *def = &world->def;
    const bool fitted = is_fitted(world);
    const bool cuts = def->plan.mode == DUET_MODE_SLAB && split_is_stale(&world->split);
    const grid_wish wish = wish_of(world);
    if (!world_take_objects(world, seen || !fitted || cuts, err))
        return false;
    if (fitted)
        return true;
    grid suited;
    grid_needs needs;
    grid_needs_of(&needs, &world->objects, threads);
    if (def->cell > 0.0f && needs.widest > def->cell && def->cell_fixed)
        return error_set(err, DUET_STATUS_CELL_TOO_SMALL,
                         "the cell edge %g is below the extent %.9g of object %u; expected a "
                         "cell at least that wide",
                         def->cell, needs.widest, needs.widest_id);
    if (!grid_fit(&suited, &needs, &wish, &world->objects, err))
        return false;
    suited.widest = needs.widest;
    take_grid(world, &suited, world->objects.all.n);
    return true;
}
