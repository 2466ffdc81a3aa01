-- SPDX-License-Identifier: MIT
return {
  about = "counts and hashes the pairs of objects that have global ids",
  uses = { "counters.h", "grid/pair_counts.h" },
  params = {
    common.WG(256),
    { "PER_ITEM", values = { 8, 16, 4096 }, default = common.by_device(4096, 8), about = "pairs a work-item" },
  },
  args = {
    change_ids = [[
      const uint4 *id_changes
      uint n_id_changes
      uint2 *global_ids
    ]],
    count_pairs = [[
      const uint2 *pairs
      const uint *counters
      uint pair_capacity
      const uint2 *global_ids
      uint n_owned
      volatile uint *pair_counts
      uint2 *left
      uint left_capacity
    ]],
  },
}
