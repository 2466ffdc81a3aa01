-- SPDX-License-Identifier: MIT
-- What a body touches, and whether it rests.
local of_rest = [[
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
  uint carrier  only if CARRIED == 1
]]

return {
  about = "which bodies sleep",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/rest.clh",
    "dynamics/listed.clh", "dynamics/sensor.clh", "dynamics/body_row.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURN, common.FRICTION, common.CONTACT_RESPONSE,
    { "SLEEP", values = { 1 }, default = 1, about = "bodies at rest are left out" },
    common.SENSORS, common.CARRIED, common.GROUP(64), common.ROWS_AN_ITEM,
  },
  args = {
    update_sleep = of_rest .. [[
      float sleep_after
      float dt
      volatile uint *asleep
      volatile uint *flags
    ]],
    wake_touching = of_rest .. [[
      volatile uint *asleep
    ]],
  },
  valid = common.can_double,
}
