-- SPDX-License-Identifier: MIT
return {
  about = "bounds of each object, in input order",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0, 1 }, default = 0, about = "0 poses, 1 bounds" },
    { "ROTATED", values = { 0, 1 }, default = 1, about = "0: every rotation is the identity" },
    { "GRID", values = { 0 }, default = 0, about = "0 dense" },
    { "LEVELS", values = { 0 }, default = 0, about = "one size of cells" },
    { "LANES", values = { 1 }, default = 1, about = "objects side by side in a work-item" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 1024 }, default = function(limits) return limits.cpu and 1024 or 1 end,
      about = "objects a work-item" },
  },
  args = {
    find_bounds = [[
      const float *objects
      uint n
      constant grid_level *levels
      uint n_levels
      float4 *bounds_by_id
      volatile uint *counters
    ]],
  },
  valid = function(p)
    if p.SHAPE == 1 and p.ROTATED == 1 then return false, "bounds have no rotation" end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
