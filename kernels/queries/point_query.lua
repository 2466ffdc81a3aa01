-- SPDX-License-Identifier: MIT
return {
  about = "which boxes of a tree contain points, or are nearest to them",
  uses = { "lanes.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh", "queries/far.clh", "queries/traversal.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0, 1 }, min = 0, max = 3, default = 0, about = "0 poses, 1 bounds, 2 rounded boxes" },
    { "ORIGIN", min = 0, max = 254, default = 0, silent = true,
      about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
    { "WANTS", values = { 2, 3 }, default = 2, about = "2 those that contain the point, 3 the nearest ones" },
    { "FILTERED", min = 0, max = 1, default = 0, silent = true, about = "1: only objects that the items' filter can touch" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "children of a node side by side" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256 }, default = function(limits) return limits.cpu and 256 or 1 end,
      about = "points a work-item" },
  },
  args = {
    point_query = [[
      const float *items
      uint n
      uint first_item
      const uint *order
      uint in_order
      const uint2 *filters   if FILTERED == 1
      uint group             if FILTERED == 1
      uint mask              if FILTERED == 1
      const float *boxes
      const float *nodes
      const uint *levels
      uint n_levels
      uint *hits
      uint hits_capacity     if WANTS == 2
      uint *open             if WANTS == 2
      uint open_capacity     if WANTS == 2
      uint each              if WANTS == 3
      volatile uint *counters
    ]],
  },
  valid = function(p)
    if p.SHAPE == 3 then return false, "spheres come as rounded boxes" end
    if p.ORIGIN > 0 and p.SHAPE > 0 then return false, "origin cells are for poses" end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
