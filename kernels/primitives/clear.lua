-- SPDX-License-Identifier: MIT
return {
  about = "zeroes what a step counts",
  params = {
    { "WG", values = { 1, 256 }, default = common.by_device(1, 256), about = "work-items a group" },
    { "PER_ITEM", values = { 1, 4, 16384 }, default = common.by_device(16384, 4), about = "words a work-item" },
  },
  args = {
    clear = [[
      uint *counters
      uint n_counters
      uint *counts
      uint n_counts
    ]],
  },
}
