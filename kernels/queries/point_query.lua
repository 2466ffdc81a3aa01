-- SPDX-License-Identifier: MIT
return {
  about = "which boxes of a tree contain points, or are nearest to them",
  uses = { "lanes.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh", "queries/far.clh", "queries/traversal.clh" },
  params = {
    common.DIMS, common.TREE_SHAPE, common.TREE_ORIGIN,
    { "WANTS", values = { 2, 3 }, default = 2, about = "2 those that contain the point, 3 the nearest ones" },
    common.FILTERED,
    { "LANES", values = { 1, 8 }, default = common.by_device(8, 1), about = "children of a node side by side" },
    common.WG(64),
    { "PER_ITEM", values = { 1, 256 }, default = common.by_device(256, 1), about = "points a work-item" },
  },
  args = {
    point_query = common.QUERY_ITEMS .. common.TREE_NODES .. [[
      uint *hits
      uint hits_capacity     if WANTS == 2
      uint *open             if WANTS == 2
      uint open_capacity     if WANTS == 2
      uint each              if WANTS == 3
      volatile uint *counters
    ]],
  },
  valid = common.can_query,
}
