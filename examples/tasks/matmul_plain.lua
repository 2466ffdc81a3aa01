-- SPDX-License-Identifier: MIT
return {
  about = "what matmul finds, an element a work-item",
  params = {},
  args = {
    matmul_plain = [[
      ulong first
      ulong last
      uint n
      const float *a
      const float *b
      float *c
    ]],
  },
  launch = function() return { group = 1, per_item = 1 } end,
}
