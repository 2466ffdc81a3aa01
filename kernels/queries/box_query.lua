-- SPDX-License-Identifier: MIT
return {
  about = "which objects of a tree other boxes collide with",
  uses = { "lanes.clh", "narrowphase/object.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "narrowphase/answer.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh", "queries/refused.clh", "queries/far.clh", "queries/traversal.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0, 1 }, min = 0, max = 3, default = 0, about = "0 poses, 1 bounds, 2 rounded boxes" },
    { "ORIGIN", min = 0, max = 254, default = 0, silent = true,
      about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
    { "ROTATED", values = { 1 }, default = 1, about = "every box has its rotation" },
    { "ACCURACY", values = { 0, 1, 2, 3, 4, 5 }, default = 0,
      about = "0 certified, 1 bounds, 2 spheres, 3 faces' axes, 4 all axes in float, 5 in double" },
    { "ITSELF", values = { 0, 1 }, default = 0, about = "1: the tree's objects against each other, by their filters" },
    { "FILTERED", min = 0, max = 1, default = 0, silent = true, about = "1: only objects that the items' filter can touch" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "boxes side by side in a work-item" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256 }, default = function(limits) return limits.cpu and 256 or 1 end,
      about = "boxes a work-item" },
  },
  args = {
    box_query = [[
      const float *items     if ITSELF == 0
      const uint2 *filters   if ITSELF == 1 or FILTERED == 1
      uint group             if FILTERED == 1
      uint mask              if FILTERED == 1
      uint n
      uint first_item
      const uint *order
      uint in_order
      const float *objects
      const float *boxes
      const float *nodes
      const uint *levels
      uint n_levels
      uint *hits
      uint hits_capacity
      uint *open
      uint open_capacity
      volatile uint *counters
    ]],
  },
  valid = function(p, limits)
    if p.ITSELF == 1 and p.FILTERED == 1 then return false, "objects that are items have filters already" end
    if p.SHAPE == 3 then return false, "spheres come as rounded boxes" end
    if p.ORIGIN > 0 and p.SHAPE > 0 then return false, "origin cells are for poses" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
