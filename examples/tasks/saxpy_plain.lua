-- SPDX-License-Identifier: MIT
return {
  about = "what saxpy finds, an element a work-item",
  params = {},
  args = {
    saxpy_plain = [[
      ulong first
      ulong last
      float a
      const float *x
      float *y
    ]],
  },
  launch = function() return { group = 64, per_item = 1 } end,
}
