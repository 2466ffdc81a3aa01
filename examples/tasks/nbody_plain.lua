-- SPDX-License-Identifier: MIT
return {
  about = "what nbody finds, one body a group and without local memory",
  params = {},
  args = {
    nbody_plain = [[
      ulong first
      ulong last
      uint n
      float softening
      float gravity
      const float4 *bodies
      float4 *acceleration
    ]],
  },
  launch = function() return { group = 1, per_item = 1 } end,
}
