-- SPDX-License-Identifier: MIT
return {
  about = "which objects of a tree other boxes collide with",
  uses = { "lanes.clh", "narrowphase/object.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "narrowphase/answer.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh", "queries/refused.clh", "queries/far.clh", "queries/traversal.clh" },
  params = {
    common.DIMS, common.TREE_SHAPE, common.TREE_ORIGIN, common.ALL_ROTATED, common.ACCURACY,
    { "ITSELF", values = { 0, 1 }, default = 0, about = "1: the tree's objects against each other, by their filters" },
    common.FILTERED,
    { "LANES", values = { 1, 8 }, default = common.by_device(8, 1), about = "boxes side by side in a work-item" },
    common.WG(64),
    { "PER_ITEM", values = { 1, 256 }, default = common.by_device(256, 1), about = "boxes a work-item" },
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
    ]] .. common.TREE_NODES .. [[
      uint *hits
      uint hits_capacity
      uint *open
      uint open_capacity
      volatile uint *counters
    ]],
  },
  valid = function(p, limits)
    if p.ITSELF == 1 and p.FILTERED == 1 then return false, "objects that are items have filters already" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
    return common.can_query(p)
  end,
}
