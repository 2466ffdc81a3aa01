-- SPDX-License-Identifier: MIT
return {
  about = "exclusive prefix sum",
  params = {
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 4, 8, 16, 8192 }, default = function(limits) return limits.cpu and 8192 or 4 end,
      about = "values a work-item" },
  },
  args = {
    scan_sums = [[
      const uint *values
      uint n
      uint *sums
    ]],
    scan_tops = [[
      uint *sums
      uint n_blocks
    ]],
    scan_blocks = [[
      uint *values
      uint n
      const uint *sums
      uint use_tops
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
