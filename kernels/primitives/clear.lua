-- SPDX-License-Identifier: MIT
return {
  about = "zeroes what a step counts",
  params = {
    { "WG", values = { 1, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 4, 16384 }, default = function(limits) return limits.cpu and 16384 or 4 end,
      about = "words a work-item" },
  },
  args = {
    clear = [[
      uint *counters
      uint n_counters
      uint *counts
      uint n_counts
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
