-- SPDX-License-Identifier: MIT
return {
  about = "y = a x + y",
  params = {
    { "WG", values = { 1, 16, 64, 256 }, about = "work-items a group",
      default = function(limits) return limits.cpu and 16 or 256 end },
    { "PER_ITEM", values = { 1, 4, 16 }, default = 1, about = "elements a work-item" },
  },
  args = {
    saxpy = [[
      ulong first
      ulong last
      float a
      const float *x
      float *y
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
