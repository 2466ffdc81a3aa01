-- SPDX-License-Identifier: MIT
return {
  about = "a tree over boxes, for queries",
  uses = { "lanes.clh", "primitives/sortable.clh", "narrowphase/object.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh",
    "queries/refused.clh", "queries/far.clh" },
  params = {
    common.DIMS, common.TREE_SHAPE, common.TREE_ORIGIN, common.ALL_ROTATED,
    { "LANES", values = { 1, 8 }, default = common.by_device(8, 1), about = "boxes side by side in a work-item" },
    { "ITEM_BITS", values = { 16, 24 }, default = common.by_device(24, 16),
      about = "bits of an item's place along the curve, by which items are sorted" },
    common.WG(128),
    { "PER_ITEM", values = { 1, 1024 }, default = common.by_device(1024, 1), about = "boxes a work-item" },
  },
  args = {
    tree_extent = [[
      const float *objects
      uint n
      uint step
      volatile uint *extent
    ]],
    tree_keys = [[
      const float *objects
      uint n
      const uint *extent
      uint *keys
      volatile uint *counters
    ]],
    item_keys = [[
      const float *items
      uint first_item
      uint item_words
      uint item_cell     if ORIGIN > 0
      uint n
      const uint *extent
      uint *keys
    ]],
    tree_leaves = [[
      const float *objects
      const uint *ids
      uint n
      uint slots
      float *boxes
      float *nodes
    ]],
    tree_level = [[
      float *nodes
      uint below
      uint n_below
      uint at
      uint n_slots
    ]],
  },
  valid = common.can_query,
}
