-- SPDX-License-Identifier: MIT
return {
  about = "objects and their bounds into cell order",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh" },
  params = {
    common.DIMS, common.SHAPE, common.ROTATED, common.ORIGIN, common.APART, common.GRID, common.LEVELS,
    { "FROM_IDS", values = { 0, 1 }, default = 1, about = "1: gathers by sorted ids, 0: scatters by cell and rank" },
    { "PACKED", values = { 0, 1 }, default = 0, about = "1: objects of one slab, with their ids" },
    common.STRETCH,
    { "UNBOXED", min = 0, max = 1, default = 0, silent = true, about = "1: boxes are read by id, and only bounds are moved" },
    common.ONE_LANE, common.WG(256), common.PER_ITEM,
    { "BATCH", values = { 1, 16 }, default = common.by_device(16, 1), about = "objects read ahead" },
  },
  args = {
    reorder = [[
      const float *objects
      const float *sizes    if APART > 0
      const uint *names     if PACKED == 1
      const uint *ids       if FROM_IDS == 1
      const uint *keys      if FROM_IDS == 0
      const uint *ranks     if FROM_IDS == 0
      uint n
      uint n_hashed         if STRETCH == 1
      const uint *starts
      uint n_own_cells
      uint place_capacity
      constant grid_level *levels
      uint n_levels
      float4 *sorted_bounds
      float4 *sorted_boxes  if SHAPE ~= 1 and UNBOXED == 0
      volatile uint *counters
      uint *next_counters
    ]],
  },
  valid = function(p)
    if p.SHAPE == 1 and p.ROTATED == 1 then return false, "bounds have no rotation" end
    if p.SHAPE == 3 and p.ROTATED == 1 then return false, "spheres have no rotation" end
    if p.SHAPE >= 2 and p.ORIGIN > 0 then return false, "what has a radius is not in origin cells" end
    if p.APART > 0 and (p.SHAPE >= 1 or p.ORIGIN > 0) then return false, "only poses from 0 have their sizes apart" end
    if p.APART > 0 and p.PACKED == 1 then return false, "what is packed is whole poses" end
  end,
}
