-- SPDX-License-Identifier: MIT
return {
  about = "counting sort: each id to its place",
  params = {
    { "STRETCH", min = 0, max = 1, default = 0, silent = true, about = "1: objects from n_hashed on" },
    { "SLAB", min = 0, max = 1, default = 0, silent = true,
      about = "1: many objects have no place, for they are another device's" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 1024 }, default = function(limits) return limits.cpu and 1024 or 1 end,
      about = "objects a work-item" },
  },
  args = {
    scatter = [[
      const uint *keys
      const uint *ranks
      uint n
      uint n_hashed  if STRETCH == 1
      const uint *starts
      uint *ids
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
