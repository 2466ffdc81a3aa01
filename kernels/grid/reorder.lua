-- SPDX-License-Identifier: MIT
return {
  about = "objects and their bounds into cell order",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0, 1 }, min = 0, max = 3, default = 0,
      about = "0 poses, 1 bounds, 2 rounded boxes, 3 spheres" },
    { "ROTATED", values = { 0, 1 }, default = 1, about = "0: every rotation is the identity" },
    { "ORIGIN", min = 0, max = 254, default = 0,
      about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
    { "APART", values = { 0, 1, 2 }, default = 0, about = "1: poses are transforms, and their sizes apart; 2: compact ones" },
    { "GRID", values = { 0, 1 }, default = 0, about = "0 dense, 1 hashed" },
    { "LEVELS", values = { 0, 1 }, default = 0, about = "1: cells of several sizes" },
    { "FROM_IDS", values = { 0, 1 }, default = 1, about = "1: gathers by sorted ids, 0: scatters by cell and rank" },
    { "PACKED", values = { 0, 1 }, default = 0, about = "1: objects of one slab, with their ids" },
    { "STRETCH", min = 0, max = 1, default = 0, silent = true, about = "1: objects from n_hashed on, to their places" },
    { "UNBOXED", min = 0, max = 1, default = 0, silent = true, about = "1: boxes are read by id, and only bounds are moved" },
    { "LANES", values = { 1 }, default = 1, about = "objects side by side in a work-item" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 1024 }, default = function(limits) return limits.cpu and 1024 or 1 end,
      about = "objects a work-item" },
    { "BATCH", values = { 1, 16 }, default = function(limits) return limits.cpu and 16 or 1 end,
      about = "objects read ahead" },
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
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
