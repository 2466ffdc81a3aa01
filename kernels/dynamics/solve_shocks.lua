-- SPDX-License-Identifier: MIT
return {
  about = "lets impacts pass through rows of bodies that touch",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/constraint.clh",
    "dynamics/restitution.clh", "dynamics/team.clh", "dynamics/colour_parts.clh" },
  params = {
    common.DIMS,
    common.TURNS,
    common.FRICTION,
    common.CONTACT_RESPONSE,
    common.CONVEYS,
    common.ROLLING,
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "contacts side by side in a work-item" },
    common.BLOCK,
    common.ROUNDED,
    common.TEAM,
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 64, 256 }, default = function(limits) return limits.cpu and limits.batch // 4 or 1 end,
      about = "contacts a work-item" },
  },
  args = {
    solve_shocks = [[
      const uint4 *spans
      int4 span
      uint from_colour
      uint to_colour
      uint each
      float *blocks
      volatile uint *team  if TEAM == 1
      uint stage          if TEAM == 1
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
