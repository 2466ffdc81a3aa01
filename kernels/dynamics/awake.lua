-- SPDX-License-Identifier: MIT
return {
  about = "lists of the bodies and contacts that a step may change",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/rest.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURN, common.CARRIED, common.GROUP(64),
    { "PER_ITEM", values = { 8, 256, 1024 }, default = common.by_batch(8),
      about = "bodies and contacts a work-item" },
  },
  args = {
    mark_awake = [[
      const real4 *velocities
      const real4 *angular_velocities  if ANGULAR_VELOCITY == 1
      const float *rests
      const uint *asleep
      uint n
      float sleep_after
      uint woken
      uint *levels
    ]],
    spread_awake = [[
      const uint2 *links
      uint n_contacts
      uint n
      uint carrier  only if CARRIED == 1
      const real4 *velocities
      uint n_parts
      volatile uint *levels
      uint *part_counts
    ]],
    count_awake = [[
      const uint *levels
      uint n
      uint n_parts
      uint *part_counts
    ]],
    list_awake = [[
      const uint *levels
      uint n
      uint carrier  only if CARRIED == 1
      const uint2 *links
      uint n_contacts
      uint n_parts
      const uint *part_counts
      uint *awake
      uint *awake_contacts
      uint *n_listed
    ]],
  },
  valid = common.can_double,
}
