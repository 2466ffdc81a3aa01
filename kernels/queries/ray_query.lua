-- SPDX-License-Identifier: MIT
return {
  about = "which boxes rays meet, or boxes that move",
  uses = { "lanes.clh", "narrowphase/object.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh",
    "queries/refused.clh", "queries/far.clh", "queries/traversal.clh", "queries/line.clh", "queries/sweep.clh", "queries/rounded_ray.clh" },
  params = {
    common.DIMS, common.TREE_SHAPE, common.TREE_ORIGIN, common.ALL_ROTATED,
    { "SWEPT", values = { 0, 1 }, default = 0, about = "0 rays, 1 boxes that move along them" },
    { "WANTS", values = { 0, 1, 2 }, default = 0, about = "0 the closest hit, 1 whether there is any, 2 every hit" },
    common.FILTERED,
    { "LANES", values = { 1, 8 }, default = common.by_device(8, 1), about = "children of a node side by side" },
    common.WG(64),
    { "PER_ITEM", values = { 1, 256 }, default = common.by_device(256, 1), about = "rays a work-item" },
  },
  args = {
    ray_query = common.QUERY_ITEMS .. common.TREE_NODES .. [[
      uint *hits
      uint hits_capacity     if WANTS == 2
      uint *open
      uint open_capacity
      volatile uint *counters
    ]],
  },
  valid = common.can_query,
}
