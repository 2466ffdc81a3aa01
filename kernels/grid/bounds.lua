-- SPDX-License-Identifier: MIT
return {
  about = "bounds of each object, in input order",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh" },
  params = {
    common.DIMS,
    { "SHAPE", values = { 0, 1 }, default = 0, about = "0 poses, 1 bounds" },
    common.ROTATED,
    { "GRID", values = { 0 }, default = 0, about = "0 dense" },
    { "LEVELS", values = { 0 }, default = 0, about = "one size of cells" },
    common.ONE_LANE, common.WG(256), common.PER_ITEM,
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
  end,
}
