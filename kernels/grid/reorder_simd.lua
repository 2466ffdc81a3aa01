-- SPDX-License-Identifier: MIT
return {
  about = "objects and their bounds into cell order, for the SIMD search",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "narrowphase/box_rows.clh", "grid/corners.clh" },
  params = {
    common.DIMS, common.SHAPE, common.ROTATED, common.ORIGIN, common.APART, common.ACCURACY, common.GRID,
    common.LEVELS,
    { "ROOMY", values = { 0, 1 }, default = 0, about = "1: dense, one size, three cells or more along x and y" },
    { "LANES", values = { 8 }, default = 8, about = "objects side by side in a work-item" },
    common.CELLS_X, common.CELLS_Y, common.CELLS_Z,
    { "WG", values = { 1 }, default = 1, about = "work-items a group" },
    { "AHEAD", values = { 0, 16, 32, 64 }, default = common.by_device(64, 0),
      about = "objects asked for before they are needed" },
    { "PER_ITEM", values = { 256, 1024, 4096 }, default = 1024, about = "objects a work-item" },
    { "TO_PLACES", min = 0, max = 1, default = 0, silent = true,
      about = "1: each object goes to its place by cell and rank, without sorted ids" },
    common.STRETCH,
  },
  args = {
    reorder_simd = [[
      const float *objects
      const float *sizes   if APART > 0
      const uint *ids      if TO_PLACES == 0
      const uint *keys     if TO_PLACES == 1
      const uint *ranks    if TO_PLACES == 1
      uint n
      uint n_hashed        if STRETCH == 1 and TO_PLACES == 1
      const uint *starts
      uint n_own_cells
      uint place_capacity
      constant grid_level *levels
      uint n_levels
      uint n_cells
      uint key_from
      float *sorted_bounds
      float *sorted_boxes  if SHAPE ~= 1
      volatile uint *counters
      uint *next_counters
    ]],
  },
  valid = function(p, limits)
    if p.AHEAD > 0 and not limits.cpu then return false, "AHEAD is for CPUs" end
    if p.ROOMY == 1 and (p.GRID == 1 or p.LEVELS == 1) then return false, "ROOMY is for dense grids of one size" end
    if p.SHAPE == 1 and p.TO_PLACES == 1 then return false, "the search reads sorted ids of bounds" end
    if p.SHAPE == 1 and p.ROTATED == 1 then return false, "bounds have no rotation" end
    if p.SHAPE == 3 and p.ROTATED == 1 then return false, "spheres have no rotation" end
    if p.SHAPE >= 2 and p.ORIGIN > 0 then return false, "what has a radius is not in origin cells" end
    if p.APART > 0 and (p.SHAPE >= 1 or p.ORIGIN > 0) then return false, "only poses from 0 have their sizes apart" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
    if (p.CELLS_X == 0) ~= (p.CELLS_Y == 0) or (p.CELLS_X == 0) ~= (p.CELLS_Z == 0) then return false, "CELLS_X, CELLS_Y and CELLS_Z go together" end
    if p.CELLS_X > 0 and (p.GRID == 1 or p.LEVELS == 1) then return false, "CELLS_X is for dense grids of one size" end
  end,
}
