-- SPDX-License-Identifier: MIT
return {
  about = "pair search for SIMD: half of the cells around, and the axis test, eight at a time",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "narrowphase/box_rows.clh", "narrowphase/collide.clh", "grid/corners.clh" },
  emit = { "stencil" },
  params = {
    common.DIMS, common.SHAPE, common.ROTATED, common.ORIGIN, common.ACCURACY, common.GRID, common.LEVELS,
    { "ROOMY", values = { 0, 1 }, default = 0, about = "1: dense, one size, three cells or more along x and y" },
    { "FUSED", values = { 0, 1 }, default = 1, about = "1: candidates are tested where they are found" },
    { "LANES", values = { 8 }, default = 8, about = "objects side by side in a work-item" },
    { "WG", values = { 1 }, default = 1, about = "work-items a group" },
    { "BUF", values = { 256, 512, 1024, 2048 }, default = 512, about = "candidates that wait for the axis test" },
    { "AHEAD", values = { 0, 16, 32, 64 }, default = common.by_device(32, 0),
      about = "boxes asked for before they are needed" },
    { "PER_ITEM", values = { 256, 1024, 4096 }, default = 1024, about = "objects a work-item" },
  },
  args = {
    pair_search_simd = [[
      const float *bounds
      uint place_capacity
      const float *boxes       if SHAPE ~= 1
      const uint *ids          if SHAPE == 1
      const uint *starts
      constant grid_level *levels
      uint n_levels
      uint n_cells
      uint key_from
      uint n_home_cells
      uint n_own_cells
      uint first
      uint last
      uint2 *found
      uint found_capacity
      uint2 *undecided         if FUSED == 1
      uint undecided_capacity  if FUSED == 1
      volatile uint *counters
    ]],
  },
  valid = function(p, limits)
    if p.AHEAD > 0 and not limits.cpu then return false, "AHEAD is for CPUs" end
    if p.ROOMY == 1 and (p.GRID == 1 or p.LEVELS == 1) then return false, "ROOMY is for dense grids of one size" end
    if (p.SHAPE == 1 or p.ACCURACY == 1) and p.FUSED == 1 then return false, "bounds need no test" end
    if p.SHAPE == 1 and p.ROTATED == 1 then return false, "bounds have no rotation" end
    if p.SHAPE == 3 and p.ROTATED == 1 then return false, "spheres have no rotation" end
    if p.SHAPE >= 2 and p.ORIGIN > 0 then return false, "what has a radius is not in origin cells" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
  end,
}
