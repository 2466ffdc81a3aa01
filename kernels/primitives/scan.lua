-- SPDX-License-Identifier: MIT
return {
  about = "exclusive prefix sum",
  params = {
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 4, 8, 16, 8192 }, default = function(limits) return limits.cpu and 8192 or 4 end,
      about = "values a work-item" },
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
