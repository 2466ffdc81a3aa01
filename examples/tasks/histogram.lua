-- SPDX-License-Identifier: MIT
return {
  about = "how often each byte occurs",
  params = {
    { "WG", values = { 16, 64, 256 }, about = "work-items a group",
      default = function(limits) return limits.cpu and 16 or 256 end },
    { "PER_ITEM", values = { 16, 64, 256 }, about = "bytes a work-item",
      default = function(limits) return limits.cpu and 256 or 64 end },
  },
  args = {
    histogram = [[
      ulong first
      ulong last
      const uchar *bytes
      uint *counts
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
