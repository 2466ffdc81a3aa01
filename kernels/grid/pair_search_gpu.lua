-- SPDX-License-Identifier: MIT
return {
  about = "pair search for GPUs: each object and half of the cells around it",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "narrowphase/boxes.clh" },
  emit = { "stencil" },
  params = {
    common.DIMS, common.SHAPE, common.GRID, common.LEVELS, common.ONE_LANE, common.ROTATED, common.ORIGIN,
    common.ACCURACY,
    { "SORTED", values = { 1 }, min = 0, max = 1, default = 1, about = "where a box is read: 0 by id, 1 in cell order" },
    { "FUSED", values = { 0, 1 }, default = 0, about = "1: candidates are tested where they are found" },
    { "JOINED", values = { 0, 1 }, default = common.by_device(0, 1),
      about = "1: one loop over all ranges around a cell" },
    { "IDS", values = { 0, 1 }, default = 0, about = "what a pair names: 0 places in cell order, 1 ids" },
    { "GUARDED", min = 0, max = 1, default = 0, silent = true,
      about = "1: nothing is searched in a grid that got more objects than it has space for" },
    common.CELLS_X, common.CELLS_Y, common.CELLS_Z,
    { "WG", values = { 1, 32, 64, 128, 256 }, default = common.by_device(1, 128), about = "work-items a group" },
    { "BUF", values = { 256, 512, 1024 }, default = 512, about = "pairs a group collects" },
    { "PER_ITEM", values = { 1, 2, 4, 256 }, default = common.by_device(256, 1), about = "objects a work-item" },
  },
  args = {
    pair_search_gpu = [[
      const float4 *bounds
      const float4 *boxes      if SHAPE ~= 1 and SORTED == 1
      const float *objects     if SORTED == 0
      const uint *starts
      constant grid_level *levels
      uint n_levels
      uint n_cells
      uint key_from
      uint n_home_cells
      uint n_own_cells         if GUARDED == 1
      uint place_capacity      if GUARDED == 1
      uint first
      uint last
      uint2 *found
      uint found_capacity
      uint2 *pairs             if FUSED == 1
      uint pair_capacity       if FUSED == 1
      uint2 *undecided         if FUSED == 1
      uint undecided_capacity  if FUSED == 1
      volatile uint *counters
    ]],
  },
  valid = function(p, limits)
    if p.BUF * 16 + 64 > limits.local_bytes then return false, "BUF above the device's local memory" end
    if (p.SHAPE == 1 or p.ACCURACY == 1) and p.FUSED == 1 then return false, "bounds need no test" end
    if p.SHAPE == 1 and p.ROTATED == 1 then return false, "bounds have no rotation" end
    if p.SHAPE == 3 and p.ROTATED == 1 then return false, "spheres have no rotation" end
    if p.SHAPE >= 2 and p.ORIGIN > 0 then return false, "what has a radius is not in origin cells" end
    if p.SORTED == 0 and (p.SHAPE ~= 0 or p.ORIGIN > 0) then return false, "only poses from 0 are read by id" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
    if (p.CELLS_X == 0) ~= (p.CELLS_Y == 0) or (p.CELLS_X == 0) ~= (p.CELLS_Z == 0) then return false, "CELLS_X, CELLS_Y and CELLS_Z go together" end
    if p.CELLS_X > 0 and (p.GRID == 1 or p.LEVELS == 1) then return false, "CELLS_X is for dense grids of one size" end
  end,
}
