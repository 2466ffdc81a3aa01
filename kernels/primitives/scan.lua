-- SPDX-License-Identifier: MIT
return {
  about = "exclusive prefix sum",
  params = {
    common.WG(256),
    { "PER_ITEM", values = { 4, 8, 16, 8192 }, default = common.by_device(8192, 4), about = "values a work-item" },
    { "EMPTIES", min = 0, max = 1, default = 0, silent = true,
      about = "1: sums go to a buffer of their own, and the values become zero" },
  },
  args = {
    scan_sums = [[
      const uint *values
      uint n
      uint *sums
    ]],
    scan_tops = [[
      uint *sums
      uint n_blocks
    ]],
    scan_blocks = [[
      uint *values
      uint *to  if EMPTIES == 1
      uint n
      const uint *sums
      uint use_tops
    ]],
    scan_at_once = [[
      uint *values
      uint *to  if EMPTIES == 1
      uint n
      volatile uint *told
      uint stamp
    ]],
  },
}
