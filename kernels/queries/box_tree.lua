-- SPDX-License-Identifier: MIT
return {
  about = "a tree over boxes, for queries",
  uses = { "lanes.clh", "narrowphase/object.clh", "queries/tree.h", "queries/rounded_row.h", "queries/far_row.h", "queries/limits.clh",
    "queries/refused.clh", "queries/far.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0, 1 }, min = 0, max = 3, default = 0, about = "0 poses, 1 bounds, 2 rounded boxes" },
    { "ORIGIN", min = 0, max = 254, default = 0, silent = true,
      about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
    { "ROTATED", values = { 1 }, default = 1, about = "every box has its rotation" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "boxes side by side in a work-item" },
    { "ITEM_BITS", values = { 16, 24 }, default = function(limits) return limits.cpu and 24 or 16 end,
      about = "bits of an item's place along the curve, by which items are sorted" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 1024 }, default = function(limits) return limits.cpu and 1024 or 1 end,
      about = "boxes a work-item" },
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
  valid = function(p)
    if p.SHAPE == 3 then return false, "spheres come as rounded boxes" end
    if p.ORIGIN > 0 and p.SHAPE > 0 then return false, "origin cells are for poses" end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
