-- SPDX-License-Identifier: MIT
return {
  about = "pairs of the bodies that commands altered, and those of all others as they were",
  uses = { "primitives/sortable.clh", "dynamics/altered.h" },
  params = {
    common.GROUP(64),
    { "PER_ITEM", values = { 1, 256, 1024 }, default = common.by_batch(1),
      about = "bodies or contacts a work-item" },
  },
  args = {
    place_altered = [[
      const uint *altered
      uint n_altered
      const float *boxes
      uint *is_altered
      float per_edge
      uint n_heads
      volatile uint *heads
      int4 *entries
      uint *nexts
      uint *wide
      volatile uint *altered_counts
    ]],
    find_altered_pairs = [[
      const uint *altered
      uint n_altered
      const float *boxes
      const uint *is_altered
      uint n
      float per_edge
      uint n_heads
      const uint *heads
      const int4 *entries
      const uint *nexts
      const uint *wide
      volatile uint *altered_counts
      uint pair_capacity
      uint2 *found_pairs
    ]],
    keep_pairs = [[
      const uint2 *links
      uint n_contacts
      const uint *is_altered
      uint n
      volatile uint *altered_counts
      uint pair_capacity
      uint2 *found_pairs
    ]],
  },
}
