-- SPDX-License-Identifier: MIT
return {
  about = "what stencil finds, a cell a work-item",
  params = {},
  args = {
    stencil_plain = [[
      ulong first
      ulong last
      uint width
      uint rows
      float rate
      const float *before
      float *after
    ]],
  },
  launch = function() return { group = 64, per_item = 1 } end,
}
