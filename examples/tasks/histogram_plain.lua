-- SPDX-License-Identifier: MIT
return {
  about = "what histogram finds, each byte counted in global memory",
  params = {},
  args = {
    histogram_plain = [[
      ulong first
      ulong last
      const uchar *bytes
      uint *counts
    ]],
  },
  launch = function() return { group = 64, per_item = 1 } end,
}
