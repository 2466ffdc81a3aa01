-- SPDX-License-Identifier: MIT
return {
  about = "acceleration of each body by the gravity of all",
  params = {
    { "WG", values = { 1, 16, 64, 128, 256 }, about = "work-items a group",
      default = function(limits) return limits.cpu and 16 or 128 end },
    { "TILE", values = { 0, 1 }, about = "1: a group reads bodies into local memory together",
      default = function(limits) return limits.cpu and 0 or 1 end },
  },
  args = {
    nbody = [[
      ulong first
      ulong last
      uint n
      float softening
      float gravity
      const float4 *bodies
      float4 *acceleration
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = 1 } end,
}
