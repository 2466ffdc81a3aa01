-- SPDX-License-Identifier: MIT
return {
  about = "lets impacts pass through rows of bodies that touch",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/constraint.clh",
    "dynamics/restitution.clh", "dynamics/team.clh", "dynamics/colour_parts.clh" },
  params = {
    common.DIMS, common.TURNS, common.FRICTION, common.CONTACT_RESPONSE, common.CONVEYS, common.ROLLING,
    common.CONTACT_LANES, common.BLOCK, common.ROUNDED, common.TEAM, common.GROUP(128), common.CONTACTS_AN_ITEM,
  },
  args = {
    solve_shocks = common.COLOURS .. common.TEAMS .. [[
      float4 *bodies
      float4 fall
      float least_speed
      float soon
      uint sweep
      uint first_sweep
      volatile uint *shocked
    ]],
  },
  valid = common.can_solve,
}
