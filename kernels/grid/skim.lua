-- SPDX-License-Identifier: MIT
return {
  about = "which objects lie deep inside a box and need no second look",
  uses = { "grid/skim.h" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0, 1 }, default = 0, about = "0 poses, 1 bounds" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
  },
  args = {
    skim = [[
      const float *objects
      uint skim_from
      uint n
      float4 inside_lower
      float4 inside_upper
      skim_block *blocks
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = 2048 // p.WG } end, -- SKIM_ROWS a group
}
