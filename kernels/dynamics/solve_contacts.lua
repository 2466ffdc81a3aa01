-- SPDX-License-Identifier: MIT
return {
  about = "solves the contacts of a colour, and applies restitution",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/constraint.clh",
    "dynamics/restitution.clh", "dynamics/team.clh", "dynamics/colour_parts.clh", "dynamics/solve_constraint.clh",
    "dynamics/restore_speeds.clh" },
  params = {
    common.DIMS, common.TURNS, common.FRICTION, common.CONTACT_RESPONSE, common.CONVEYS, common.ROLLING,
    common.CONTACT_LANES, common.BLOCK, common.ROUNDED, common.TEAM, common.GROUP(128), common.CONTACTS_AN_ITEM,
  },
  args = {
    solve_contacts = common.COLOURS .. common.TEAMS .. [[
      float4 *bodies
      uint soft
      float per_h
      float4 spring
      float4 hard_spring
      float load_speed
    ]],
    apply_restitution = common.COLOURS .. common.TEAMS .. [[
      float4 *bodies
      float4 fall
      float least_speed
    ]],
  },
  valid = common.can_solve,
}
