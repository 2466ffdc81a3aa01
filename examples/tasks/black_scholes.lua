-- SPDX-License-Identifier: MIT
return {
  about = "prices of European options by Black and Scholes",
  params = {
    { "WG", values = { 1, 16, 64, 256 }, about = "work-items a group",
      default = function(limits) return limits.cpu and 16 or 256 end },
    { "PER_ITEM", values = { 1, 4, 16 }, default = 1, about = "options a work-item" },
  },
  args = {
    black_scholes = [[
      ulong first
      ulong last
      float rate
      float volatility
      const float *price
      const float *strike
      const float *years
      float *call
      float *put
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
