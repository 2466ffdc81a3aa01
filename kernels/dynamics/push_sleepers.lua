-- SPDX-License-Identifier: MIT
return {
  about = "bodies that sleep deep in each other are pushed apart",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/listed.clh", "dynamics/sensor.clh",
    "dynamics/team.clh", "dynamics/meet.clh", "dynamics/body_row.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.ORIGIN, common.TURN, common.FRICTION, common.CONTACT_RESPONSE,
    { "SLEEP", values = { 1 }, default = 1, about = "bodies at rest are left out" },
    common.SENSORS, common.TEAM, common.MEET, common.GROUP(64),
    { "PER_ITEM", values = { 1 }, default = 1, about = "bodies a work-item at least" },
  },
  args = {
    push_sleepers = [[
      const uint2 *links
      const uint *touches
      const uint *starts
      const uint *return_starts
      const uint *returns
      const uint *asleep
      const real4 *velocities
      const float *sensors  if SENSORS == 1
      uint n
      const uint *awake
      const uint *n_listed
      uint all_awake
      float margin
      uint from_round
      uint to_round
      uint hopes
      const uint *flags
      volatile uint *team   if TEAM == 1 or MEET == 1
      uint stage            if TEAM == 1
      float dt
      float *contacts
      float4 *bodies
      real4 *centres
      int4 *cells           if ORIGIN > 0
      float *rests
    ]],
  },
  valid = function(p, limits)
    if p.MEET == 1 and p.WG == 1 then return false, "groups that meet have several work-items" end
    return common.can_double(p, limits)
  end,
}
