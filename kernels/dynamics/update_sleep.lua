-- SPDX-License-Identifier: MIT
return {
  about = "which bodies sleep; those that do deep in each other are pushed apart",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/rest.clh",
    "dynamics/listed.clh" },
  params = {
    common.DIMS,
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
    { "ORIGIN", min = 0, max = 254, default = 0,
      about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
    { "ANGULAR_VELOCITY", values = { 0, 1 }, default = 0, about = "1: objects turn" },
    common.FRICTION,
    common.CONTACT_RESPONSE,
    { "SLEEP", values = { 1 }, default = 1, about = "bodies at rest are left out" },
    { "SENSORS", values = { 0, 1 }, default = 0, about = "1: some bodies are sensors" },
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = function(limits) return limits.cpu and limits.batch or 1 end,
      about = "objects, pairs or contacts a work-item" },
  },
  args = {
    update_sleep = [[
      const uint2 *links
      const uint *touches
      const uint *starts
      const uint *return_starts
      const uint *returns
      uint n
      const uint *awake
      const uint *n_listed
      uint all_awake
      const float *rests
      const real4 *velocities
      const real4 *angular_velocities  if ANGULAR_VELOCITY == 1
      const float *sensors             if SENSORS == 1
      float sleep_after
      float dt
      uint *asleep
      volatile uint *flags
    ]],
    push_sleepers = [[
      const uint *touches
      const uint *starts
      const uint *return_starts
      const uint *returns
      const uint2 *links
      const uint *asleep
      const real4 *velocities
      const float *sensors  if SENSORS == 1
      uint n
      const uint *awake
      const uint *n_listed
      uint all_awake
      float margin
      uint round
      float *contacts
      float4 *bodies
    ]],
    move_sleepers = [[
      const uint *touches
      const uint *starts
      const uint2 *links
      const uint *asleep
      const real4 *velocities
      const float *sensors  if SENSORS == 1
      uint n
      const uint *awake
      const uint *n_listed
      uint all_awake
      float margin
      uint round
      float dt
      float *contacts
      float4 *bodies
      real4 *centres
      int4 *cells           if ORIGIN > 0
      float *rests
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.DOUBLE == 1 and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    return true
  end,
}
