-- SPDX-License-Identifier: MIT
return {
  about = "which objects lie deep inside a box and need no second look",
  uses = { "grid/interior.h" },
  params = {
    common.DIMS,
    { "SHAPE", values = { 0, 1 }, default = 0, about = "0 poses, 1 bounds" },
    common.WG(256),
  },
  args = {
    find_interior = [[
      const float *objects
      uint interior_from
      uint n
      float4 inside_lower
      float4 inside_upper
      interior_block *blocks
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = 2048 // p.WG } end, -- INTERIOR_ROWS a group
}
