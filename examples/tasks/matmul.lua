-- SPDX-License-Identifier: MIT
return {
  about = "product of two square matrices",
  params = {
    { "WG", values = { 1, 16, 64 }, about = "work-items a group",
      default = function(limits) return limits.cpu and 1 or 64 end },
    { "COLUMNS", values = { 1, 2, 4, 8, 16 }, about = "elements of a row a work-item",
      default = function(limits) return limits.cpu and 16 or 4 end },
  },
  args = {
    matmul = [[
      ulong first
      ulong last
      uint n
      const float *a
      const float *b
      float *c
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.COLUMNS } end,
}
